"""Counterfactual paired variants: the same scene and camera again with one thing changed."""

from warehouse_sim.generation.paired_variants.config import PairedVariantsConfig
from warehouse_sim.generation.paired_variants.variants import Variant, base_variant, make_variants

__all__ = ["PairedVariantsConfig", "Variant", "base_variant", "make_variants"]
