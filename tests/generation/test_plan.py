"""What a dataset will be, rejected where nobody can mean it."""

import pytest

from warehouse_sim.errors import ConfigError
from warehouse_sim.generation.plan import GenerateConfig, plan_dataset
from warehouse_sim.generation.recipe import load_recipe


@pytest.mark.parametrize(
    ("formats", "words"), [((), "a dataset needs one at least"), (("bop", "kitti", "bop"), "names one twice")]
)
def test_formats_are_named_once_each_and_there_is_one(formats: tuple[str, ...], words: str) -> None:
    with pytest.raises(ConfigError, match=words):
        plan_dataset(load_recipe("smoke"), GenerateConfig(formats=formats))
