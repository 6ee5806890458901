import pytest

from tests.scene.sites import built
from warehouse_sim.errors import ConfigError
from warehouse_sim.scene.draft import SceneDraft
from warehouse_sim.scene.layouts.dock_staging import DockStagingConfig
from warehouse_sim.schema import ObjectInstance


def build(**settings: object) -> tuple[SceneDraft, DockStagingConfig, int]:
    config = DockStagingConfig(**settings)  # type: ignore[arg-type]
    draft, site = built(config)
    return draft, config, len(site.lanes)


def named(draft: SceneDraft, name: str) -> list[ObjectInstance]:
    return [item for item in draft.instances if item.model == name]


@pytest.mark.parametrize(("doors", "fraction", "opened"), [(1, 0.0, 0), (3, 1.0, 3), (4, 0.5, 2), (6, 0.5, 3)])
def test_each_opening_of_the_wall_has_a_door_and_open_ones_a_trailer(doors: int, fraction: float, opened: int) -> None:
    draft, _, lanes = build(doors=doors, open_fraction=fraction, lanes_per_door=2)
    assert lanes == 2 * doors
    leaves = named(draft, "dock_door_open") + named(draft, "dock_door_closed")
    openings = named(draft, "wall_module_dock")
    x = sorted(float(item.T_world_object[0, 3]) for item in openings)
    assert x == sorted(float(item.T_world_object[0, 3]) for item in leaves)
    assert len(x) == len(named(draft, "dock_leveller")) == doors
    for name in ("dock_door_open", "trailer", "dock_seal"):
        assert len(named(draft, name)) == opened
    assert len(openings) + len(named(draft, "wall_module")) == 8


def test_doors_end_at_the_wall_trailers_begin_behind_it_and_the_apron_is_free() -> None:
    draft, config, _ = build(open_fraction=0.5)
    wall = named(draft, "wall_module_dock")[0]
    inner = wall.T_world_object[1, 3] - draft.models["wall_module_dock"].size[1] / 2
    assert inner == pytest.approx(config.depth)
    for name in ("dock_door_open", "dock_door_closed"):
        for item in named(draft, name):
            size = draft.models[name].size
            assert item.T_world_object[1, 3] + size[1] / 2 == pytest.approx(inner)
            assert item.T_world_object[2, 3] == pytest.approx(size[2] / 2)
    for name, start in (("dock_seal", 0.2), ("trailer", 0.4)):  # the wall is 0.2 m thick, and so is the seal
        for item in named(draft, name):
            size = draft.models[name].size
            assert item.T_world_object[1, 3] - size[1] / 2 == pytest.approx(inner + start)
            assert item.T_world_object[1, 3] + size[1] / 2 < 24.0
    # At rest a leveller ends at the wall; at an open door its lip lies on the trailer's floor.
    open_x = {float(item.T_world_object[0, 3]) for item in named(draft, "trailer")}
    for item in named(draft, "dock_leveller"):
        end = item.T_world_object[1, 3] + draft.models["dock_leveller"].size[1] / 2 - inner
        assert end == pytest.approx(0.55 if float(item.T_world_object[0, 3]) in open_x else 0.0)
    assert config.apron > draft.models["dock_leveller"].size[1]


def test_too_many_lanes_for_a_door_are_rejected() -> None:
    with pytest.raises(ConfigError, match=r"4 lanes of 1.6 m do not fit the 6.0 m"):
        DockStagingConfig(lanes_per_door=4, lane_width=1.6)
