"""Counterfactual twins: the same scene and camera again with one thing changed."""

from warehouse_sim.generation.twins.config import TwinsConfig
from warehouse_sim.generation.twins.variants import Variant, base_variant, make_variants

__all__ = ["TwinsConfig", "Variant", "base_variant", "make_variants"]
