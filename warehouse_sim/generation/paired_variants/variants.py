"""The variants of a finished scene: each is a scene of its own that shares all that its change leaves alone."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from warehouse_sim.catalog import materials
from warehouse_sim.generation.paired_variants.config import MaterialVariant, NoiseVariant, PairedVariantsConfig
from warehouse_sim.schema import Material, SceneSpec
from warehouse_sim.sensors.rig import SensorChoice


@dataclass(frozen=True, eq=False)
class Variant:
    """One way in which all viewpoints of a scene are observed."""

    name: str
    """"base" for the scene itself."""
    scene: SceneSpec
    """What is sampled."""
    sensor: SensorChoice
    """The RGB-D camera."""
    noise_sample: int = 0
    """Number of the noise sample of sensors that depend on light; 0 is that of the base."""
    absent: tuple[int, ...] = ()
    """Instance ids of the base that are taken away."""
    absent_from: tuple[tuple[int, ...], ...] = ()
    """Instance ids that one viewpoint does without, for each of them; empty = all see the whole scene."""

    def seen_from(self, viewpoint_index: int) -> "Variant":
        """Return the variant as one viewpoint has it: without what is absent from there."""
        gone = self.absent_from[viewpoint_index] if self.absent_from else ()
        if not gone:
            return self
        kept = tuple(item for item in self.scene.instances if item.instance_id not in gone)
        return replace(self, scene=replace(self.scene, instances=kept), absent=tuple(sorted(gone)), absent_from=())


Relight = Callable[[SceneSpec, dict[str, Any]], SceneSpec]
"""Return a scene under settings that replace some of the recipe's ``scene.lights``."""


def base_variant(scene: SceneSpec, sensor: SensorChoice) -> Variant:
    """Return the scene itself as its only variant."""
    return Variant("base", scene, sensor)


def make_variants(
    scene: SceneSpec,
    config: PairedVariantsConfig,
    sensor: SensorChoice,
    occluders: Sequence[Sequence[int]],
    relight: Relight,
) -> tuple[Variant, ...]:
    """Return the base and its paired variants in the order of ``config.names()``.

    Args:
        scene: Settled, lit, with its final viewpoints.
        config: What to change.
        sensor: The rig's own camera in this scene.
        occluders: For each viewpoint the instance ids of the objects that its own request put before its target.
        relight: Sets another light.
    """
    base = base_variant(scene, sensor)
    variants = [base]
    if config.without_occluders:
        variants.append(replace(base, name="without occluders", absent_from=tuple(map(tuple, occluders))))
    variants += [
        replace(base, name=paired_variant.name, scene=relight(scene, paired_variant.settings))
        for paired_variant in config.lights
    ]
    variants += [
        replace(base, name=paired_variant.name, scene=_resurfaced(scene, paired_variant))
        for paired_variant in config.materials
    ]
    variants += [
        replace(
            base, name=paired_variant.name, sensor=_renoised(sensor, paired_variant), noise_sample=paired_variant.sample
        )
        for paired_variant in config.noise
    ]
    return tuple(variants)


def _renoised(sensor: SensorChoice, paired_variant: NoiseVariant) -> SensorChoice:
    """Return the camera with the paired variant's own settings, under the variant's name where it has any."""
    return sensor if paired_variant.rgbd is None else SensorChoice(paired_variant.name, paired_variant.rgbd)


def _resurfaced(scene: SceneSpec, paired_variant: MaterialVariant) -> SceneSpec:
    """Return the scene with the appearance of some materials replaced; names stay, since parts refer to them."""
    appearances = materials()

    def appearance(name: str, material: Material) -> Material:
        return replace(appearances[paired_variant.swap[name]], name=name) if name in paired_variant.swap else material

    return replace(scene, materials={name: appearance(name, item) for name, item in scene.materials.items()})
