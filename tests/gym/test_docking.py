"""The task for learning: an environment as gymnasium has them, decided by its seed, and no easier than docking is."""

import subprocess
import sys
import time
import warnings
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import warehouse_sim.gym
from warehouse_sim.benchmark.docking.closed_loop.settings import DRIVE
from warehouse_sim.errors import InputError
from warehouse_sim.generation.plan import target_models
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.gym.agents import PursuitAgent, RandomAgent
from warehouse_sim.gym.command import Command
from warehouse_sim.gym.score import Episode, episodes, summary

NAME = warehouse_sim.gym.ENVIRONMENT
IN, STOP = Command(goes_in=True, way=1.0), Command()


def made(**settings: Any) -> gymnasium.Env[Any, Any]:
    return gymnasium.make(NAME, **{"recipe": "smoke", "scenes": 3, **settings})


@pytest.fixture(scope="module")
def env() -> gymnasium.Env[Any, Any]:
    return made()


@pytest.mark.gl
def test_gymnasium_finds_nothing_to_say() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(made().unwrapped)


@pytest.mark.gl
def test_images_pass_its_check_too_and_show_the_pallet() -> None:
    with made(observes="images", scenes=1) as env, warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env.unwrapped, skip_render_check=True)
        seen, known = env.reset(seed=3)
        assert seen["mask"].sum() > 200
        inside = seen["depth"][(seen["mask"] > 0) & (seen["depth"] > 0)]
        assert 1.0 < np.median(inside) < 7.0
        assert known["obj_id"] in {model.obj_id for model in target_models(load_recipe("smoke"))}
        first = [env.step(STOP.action)[0] for _ in range(11)]
        np.testing.assert_array_equal(first[8]["rgb"], seen["rgb"])  # a new image each second
        assert (first[9]["depth"] != seen["depth"]).any()
        ages = [float(item["truck"][7]) for item in first]
        np.testing.assert_allclose(ages, [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.0, 0.1], atol=1e-6)


def test_the_seed_alone_decides_an_episode(env: gymnasium.Env[Any, Any]) -> None:
    def rewards(seed: int, other: int | None) -> list[float]:
        if other is not None:  # whatever was driven before
            list(episodes(env, RandomAgent(np.random.default_rng(other)), [other]))
        agent, (seen, known) = PursuitAgent(), env.reset(seed=seed)
        agent.begin(known)
        found = []
        for _ in range(30):
            seen, reward, *_ = env.step(agent.act(seen))
            found += [reward, *seen.tolist()]
        return found

    assert rewards(5, None) == rewards(5, 7) != rewards(6, None)


def test_true_poses_dock_and_random_orders_do_not(env: gymnasium.Env[Any, Any]) -> None:
    scripted = list(episodes(env, PursuitAgent(), range(6)))
    assert [item.outcome for item in scripted] == ["docked"] * 6
    assert all(1.0 < item.reward < 2.0 for item in scripted)
    lost = list(episodes(env, RandomAgent(np.random.default_rng(0)), range(6)))
    assert "docked" not in {item.outcome for item in lost}


@pytest.mark.parametrize(
    ("off", "outcomes"),
    [
        (Command(way=-0.6), {"not lifted", "fell"}),
        (Command(way=0.5), {"struck", "pushed"}),
        (Command(up=0.1), {"struck", "pushed", "not lifted"}),
    ],
)
def test_going_in_too_short_too_far_or_too_high_does_not_dock(
    env: gymnasium.Env[Any, Any], off: Command, outcomes: set[str]
) -> None:
    agent, (seen, known) = PursuitAgent(), env.reset(seed=1)
    agent.begin(known)
    while True:
        order = Command.of(agent.act(seen))
        if order.goes_in:
            order = Command(goes_in=True, way=order.way + off.way, up=order.up + off.up)
        seen, reward, ended, _, info = env.step(order.action)
        if ended:
            break
    assert info["outcome"] in outcomes
    assert reward < 0.5


def test_a_truck_that_drives_on_collides_and_one_that_stands_times_out(env: gymnasium.Env[Any, Any]) -> None:
    straight = Command(speed=DRIVE.speed)
    env.reset(seed=2)
    ended = truncated = False
    while not ended and not truncated:
        _, reward, ended, truncated, info = env.step(straight.action)
    assert (info, ended) == ({"outcome": "collided"}, True)
    assert reward == pytest.approx(-1.0, abs=0.01)
    env.reset(seed=2)
    steps = 0
    while not truncated:
        seen, _, _, truncated, _ = env.step(STOP.action)
        steps += 1
    assert steps == warehouse_sim.gym.MOST_STEPS
    assert seen[7] == pytest.approx(90.0, abs=1e-3)


def test_an_episode_that_has_ended_goes_on_after_a_reset_only() -> None:
    with made().unwrapped as env:
        with pytest.raises(InputError, match=r"no episode is going on; call reset\(\)"):
            env.step(STOP.action)
        env.reset(seed=1)
        assert env.step(IN.action)[2]
        with pytest.raises(InputError, match=r"no episode is going on; call reset\(\)"):
            env.step(STOP.action)
        env.reset()
        assert not env.step(STOP.action)[2]


def test_steps_with_poses_are_faster_than_twenty_a_second(env: gymnasium.Env[Any, Any]) -> None:
    list(episodes(env, PursuitAgent(), [0]))  # scenes are sampled once
    begun = time.process_time()
    (driven,) = episodes(env, PursuitAgent(), [0])
    assert driven.steps / (time.process_time() - begun) > 20.0


def test_actions_and_orders_say_the_same() -> None:
    order = Command(speed=0.3, curvature=-0.4, goes_in=True, way=1.23, up=-0.07)
    again = Command.of(order.action)
    for name in ("speed", "curvature", "way", "up"):
        assert getattr(again, name) == pytest.approx(getattr(order, name), abs=1e-6)
    assert again.goes_in
    assert Command.of(np.full(5, 7.0, np.float32)) == Command.of(np.ones(5, np.float32))
    for wrong in (np.array([0.0, np.nan, 0.0, 0.0, 0.0]), np.zeros(4)):
        with pytest.raises(InputError, match=r"an action is five numbers from -1 to 1, found \[0\.0, (nan|0\.0), "):
            Command.of(wrong)


def test_scores_are_fractions_with_intervals() -> None:
    ends = ["docked", "docked", "struck", "timed out"]
    found = summary("x", [Episode(n, n % 2, end, 1.0, 10, 0.5, 0.25) for n, end in enumerate(ends)])
    assert (found["value"], found["episodes"], found["scenes"]) == (0.5, 4, 2)
    assert found["steps_a_cpu_second"] == pytest.approx(40.0)
    assert found["steps_a_cpu_second_with_resets"] == pytest.approx(40 / 3)
    low, high = found["interval"]
    assert low < 0.5 < high


def test_what_there_is_not_is_named() -> None:
    with pytest.raises(InputError, match="'sounds'"):
        made(observes="sounds")


def test_without_gymnasium_the_package_is_there_and_the_task_says_what_to_install() -> None:
    lacks = "import sys; sys.modules['gymnasium'] = None; import warehouse_sim as ws; ws.Dataset; print('there')"
    code = f"{lacks}; import warehouse_sim.gym"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert done.stdout.strip() == "there"
    assert done.stderr.strip().endswith("pip install 'warehouse-sim[gym]'")
