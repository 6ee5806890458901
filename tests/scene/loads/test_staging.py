import numpy as np

from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import make_transform
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.scene import Distribution
from warehouse_sim.scene.draft import Area, SceneDraft
from warehouse_sim.scene.loads.staging import StagingConfig, stage_loads
from warehouse_sim.scene.loads.unit_load import UnitLoadConfig


def test_loads_keep_their_distance_and_head_everywhere() -> None:
    yaws = []
    for seed in range(10):
        draft = SceneDraft()
        config = StagingConfig(count=Distribution.constant(5), depth=Distribution.uniform(1.6, 7.4))
        stage_loads(draft, config, UnitLoadConfig(), Area(-6, 6, -9, 0), np.random.default_rng(seed))
        stacks = {}
        for group in range(1, 6):
            members = [item for item in draft.instances if item.group == group]
            stacks[group] = BoxStack.of([OrientedBox(i.T_world_object, draft.models[i.model].size) for i in members])
            T = members[0].T_world_object
            assert -9 + 1.6 <= T[1, 3] <= -1.6
            yaws.append(np.arctan2(T[1, 0], T[0, 0]))
        for a in range(1, 6):
            for b in range(1, a):
                every = np.argwhere(np.ones((len(stacks[a].half), len(stacks[b].half)), dtype=bool))
                assert stacks[a].separation(stacks[b], every).distance.min() >= 0.4 - 1e-9
    counts, _ = np.histogram(yaws, bins=4, range=(-np.pi, np.pi))
    assert counts.min() > 0


def test_loads_keep_clear_of_what_is_fixed_on_the_floor() -> None:
    for seed in range(8):
        draft = SceneDraft()
        for x in (-2.0, 0.0, 2.0):
            draft.add("rubbish_bin", make_transform(translation=np.array([x, -3.0, 0.533])))
        config = StagingConfig(count=Distribution.constant(4), depth=Distribution.uniform(1.6, 4.4))
        stage_loads(draft, config, UnitLoadConfig(), Area(-4, 4, -6, 0), np.random.default_rng(seed))
        bins = BoxStack.of([OrientedBox(i.T_world_object, draft.models[i.model].size) for i in draft.instances[:3]])
        for item in draft.instances[3:]:
            assert bins.clear_of(OrientedBox(item.T_world_object, draft.models[item.model].size), -1e-9)
