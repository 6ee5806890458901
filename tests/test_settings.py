"""Every number of every settings class of the package has a range, its docstring says it, and it holds."""

import ast
import dataclasses
import functools
import inspect
import itertools
import math
import re
import textwrap
import typing
from collections.abc import Iterator
from typing import Annotated, Any

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from warehouse_sim.catalog.custom_config import CustomObjectConfig
from warehouse_sim.config import convert, from_mapping, to_mapping
from warehouse_sim.errors import ConfigError
from warehouse_sim.estimators.detectors.settings import DetectorConfig
from warehouse_sim.estimators.pose.densefusion.calibration import Calibration
from warehouse_sim.estimators.pose.densefusion.networks.densefusion import PoseRun
from warehouse_sim.estimators.pose.densefusion.settings import TrainConfig
from warehouse_sim.estimators.segmenters.segnet.settings import SegmenterConfig
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.generation.plan import GenerateConfig
from warehouse_sim.generation.recipe import Recipe
from warehouse_sim.ranges import Range, range_of, ranges_of
from warehouse_sim.scene.distribution import Distribution
from warehouse_sim.scene.layouts.site import Layout
from warehouse_sim.scene.random_settings import RandomSetting
from warehouse_sim.sensors.rgbd.depth.model import DepthModel
from warehouse_sim.sensors.rgbd.depth.models import MODELS, read_depth_model

ROOTS = (
    *(Recipe, CustomObjectConfig, GenerateConfig, TrainConfig, PredictConfig, DetectorConfig, SegmenterConfig),
    *(PoseRun, Calibration),
)
KINDS = {Layout: tuple(Layout.kinds.values()), DepthModel: tuple(MODELS.values())}
"""Abstract settings and all that a file can name in their place."""
NUMBERS = (int, float, Distribution)
# A file cannot give random settings: they are what a recipe's distributions become, checked where those stand.
NOT_READ = (RandomSetting,)


def settings_classes() -> list[type]:
    found: list[type] = []

    def walk(hint: Any) -> None:
        if dataclasses.is_dataclass(hint) and hint not in (*NOT_READ, Distribution):
            if hint in found:
                return
            found.append(hint)
            for name in (field.name for field in dataclasses.fields(hint)):
                walk(typing.get_type_hints(hint)[name])
            for kind in KINDS.get(hint, ()):
                walk(kind)
        for inner in typing.get_args(hint):
            walk(inner)

    for root in ROOTS:
        walk(root)
    return found


def naked_numbers(hint: Any, covered: bool = False) -> Iterator[Any]:
    """Yield the numbers in a type that no ``Range`` speaks of."""
    if typing.get_origin(hint) is Annotated:
        yield from naked_numbers(hint.__origin__, covered or range_of(hint) is not None)
    elif hint in NUMBERS:
        if not covered:
            yield hint
    elif typing.get_origin(hint) is not typing.Literal and not dataclasses.is_dataclass(hint):
        for inner in typing.get_args(hint):
            yield from naked_numbers(inner, covered)


@functools.cache
def docstrings(cls: type) -> dict[str, str]:
    """Return the string after each field of a class, its bases included."""
    found = docstrings(cls.__base__) if dataclasses.is_dataclass(cls.__base__) else {}
    body = ast.parse(textwrap.dedent(inspect.getsource(cls))).body[0].body
    for field, text in itertools.pairwise(body):
        if isinstance(field, ast.AnnAssign) and isinstance(text, ast.Expr) and isinstance(text.value, ast.Constant):
            found[field.target.id] = " ".join(text.value.value.split())
    return found


CLASSES = settings_classes()
RANGED = [(cls, name, allowed) for cls in CLASSES for name, allowed in ranges_of(cls).items()]


def test_the_walk_reaches_what_files_and_command_lines_hold() -> None:
    names = {cls.__name__ for cls in CLASSES}
    assert {"LidarConfig", "SgbmConfig", "DockStagingConfig", "TimeOfFlight", "AttentionConfig"} <= names
    assert len(RANGED) > 250


def test_every_number_has_a_range() -> None:
    for cls in CLASSES:
        hints = typing.get_type_hints(cls, include_extras=True)
        naked = [field.name for field in dataclasses.fields(cls) if list(naked_numbers(hints[field.name]))]
        assert not naked, cls


def test_the_docstring_tells_the_range() -> None:
    for cls, name, allowed in RANGED:
        if allowed != Range(0, 2**63 - 1):  # a seed is any number
            assert re.search(rf"(?<![\d.]){re.escape(str(allowed))}(?![\d]|\.\d)", docstrings(cls)[name]), (cls, name)


def has_default(field: dataclasses.Field) -> bool:
    return field.default is not dataclasses.MISSING or field.default_factory is not dataclasses.MISSING


def sample(cls: type) -> Any:
    needed = {field.name: None for field in dataclasses.fields(cls) if not has_default(field)}
    made = cls.__new__(cls)
    for field in dataclasses.fields(cls):
        default = field.default_factory() if field.default_factory is not dataclasses.MISSING else field.default
        object.__setattr__(made, field.name, None if field.name in needed else default)
    return made


def test_the_class_keeps_to_the_range() -> None:
    for cls, name, allowed in RANGED:
        if inspect.isabstract(cls):
            continue
        for bad in (math.nan, math.inf, -math.inf, allowed.low - 1, 2 * allowed.high + 1):
            settings = sample(cls)
            object.__setattr__(settings, name, bad)
            with pytest.raises((ConfigError, ValueError), match=f"^{name} must be {re.escape(str(allowed))}.*, found "):
                settings.__post_init__()


SINGLE = [
    (cls, name, allowed)
    for cls, name, allowed in RANGED
    if not inspect.isabstract(cls) and typing.get_type_hints(cls)[name] in (int, float, Distribution)
]
"""The settings that hold one number, of the classes that a file can hold."""


@given(st.sampled_from(SINGLE), st.floats(0.0, 1.0))
def test_a_number_within_its_range_survives_the_round_trip(setting: tuple[type, str, Range], fraction: float) -> None:
    cls, name, allowed = setting
    number = allowed.low + fraction * (allowed.high - allowed.low)
    hint = typing.get_type_hints(cls)[name]
    whole = hint is int or allowed.whole
    try:
        config = from_mapping(cls, {name: min(round(number), int(allowed.high)) if whole else number}, "file")
    except ConfigError as problem:  # a relation to another setting, or the want of one that has no default
        rejected = str(problem)
    else:
        rejected = ""
    assert f"{name} must be {allowed}" not in rejected
    assume(not rejected)
    plain = to_mapping(config)
    # A depth model is written with its name, by which files choose it.
    again = read_depth_model(plain, "again") if isinstance(config, DepthModel) else convert(cls, plain, "again")
    assert again == config


@given(st.sampled_from(SINGLE), st.floats(1e-6, 1e6), st.booleans())
def test_a_number_outside_of_its_range_is_rejected_by_name(
    setting: tuple[type, str, Range], beyond: float, above: bool
) -> None:
    cls, name, allowed = setting
    hint = typing.get_type_hints(cls)[name]
    number = allowed.high * (1 + 1e-9) + beyond if above else allowed.low - beyond
    if hint is int:
        number = math.ceil(number) if above else math.floor(number)
    needed = [item.name for item in dataclasses.fields(cls) if not has_default(item) and item.name != name]
    assume(not needed)
    with pytest.raises(ConfigError, match=rf"{name}.* must (be|stay within) {re.escape(str(allowed))}"):
        from_mapping(cls, {name: number}, "file")
