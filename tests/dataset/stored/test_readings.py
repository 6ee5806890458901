"""A sensor that is neither camera nor LiDAR: what it reads is stored beside the formats, read back and checked."""

import json
import shutil
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from tests.dataset.toy import CAMERA, PALLET, make_dataset, make_manifest, make_scene, observe, with_recipe
from warehouse_sim.dataset.manifest import read_manifest
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.store import DatasetStore
from warehouse_sim.dataset.stored.readings import encode_reading
from warehouse_sim.dataset.validate import validate
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.pose import make_transform
from warehouse_sim.schema import MountedReading, Observation

T_CAMERA_RING = make_transform(translation=np.array([0.0, 0.4, -0.1]))
RECIPE = {"sensors": {"more": {"ring": {"sensor": "ultrasonic_ring", "count": 8}}}}


@dataclass(frozen=True, eq=False)
class RingReading:
    """Ranges of a ring, and echoes, as many as there are."""

    channels: dict
    units = {"ranges": "m"}  # noqa: RUF012


def with_ring(observation: Observation) -> Observation:
    rng = np.random.default_rng([observation.scene_index, observation.observation_index])
    channels = {"ranges": rng.uniform(0, 5, 8).astype(np.float32), "echoes": np.arange(rng.integers(1, 9))}
    return observation.with_reading("ring", RingReading(channels), T_CAMERA_RING)


def make(root: Path, change=with_ring) -> Path:
    return make_dataset(root, with_recipe(make_manifest(), RECIPE), change=change)


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make(tmp_path_factory.mktemp("ring") / "data")


def test_the_manifest_says_what_it_gives(made: Path) -> None:
    contents = read_manifest(made).contents
    assert contents.sensors == {"ring": "ultrasonic_ring"}
    ring = contents.readings["ring"]
    ranges, echoes = ring.channels["ranges"], ring.channels["echoes"]
    assert ring.kind == "ultrasonic_ring"
    assert (ranges.dtype, ranges.shape, ranges.unit) == ("<f4", (8,), "m")
    assert (echoes.dtype, echoes.shape, echoes.unit) == ("<i8", (None,), "")


def test_the_reader_gives_back_what_was_read(made: Path) -> None:
    reader = DatasetReader(made)
    for split in reader.splits:
        for image in reader.images(split):
            (name, item), *others = reader.readings(image).items()
            gt = with_ring(observe(make_scene(image.scene_id))[image.image_id]).readings["ring"]
            assert (name, others) == ("ring", [])
            assert np.array_equal(item.T_camera_sensor, T_CAMERA_RING)
            for channel, array in gt.reading.channels.items():
                assert item.reading.channels[channel].dtype == array.dtype
                assert np.array_equal(item.reading.channels[channel], array)


def test_the_files_are_those_of_numpy_and_the_same_each_time(made: Path, tmp_path: Path) -> None:
    path = made / "readings/ring/000001_000000.npz"
    with np.load(path, allow_pickle=False) as arrays:
        assert set(arrays) == {"T_camera_sensor", "ranges", "echoes"}
    again = make(tmp_path / "again")
    assert (again / "readings/ring/000001_000000.npz").read_bytes() == path.read_bytes()


def test_it_validates_and_every_other_file_is_as_without_it(made: Path, toy_root: Path) -> None:
    checks = validate(made)
    assert [check for check in checks if not check.ok] == []
    assert {check.name: check.detail for check in checks}["readings"] == "6 readings of ring"
    assert "readings" not in {check.name for check in validate(toy_root)}
    own = {path.relative_to(toy_root) for path in toy_root.rglob("*") if path.is_file()}
    told = {Path("manifest.json"), Path("SHA256SUMS"), Path("README.md"), Path("card/recipe.yaml")}
    told |= {Path(f"scenes/{index:06d}.json") for index in range(3)}
    for path in own - told:
        assert (toy_root / path).read_bytes() == (made / path).read_bytes()


def put(path: Path, **channels: np.ndarray) -> None:
    path.write_bytes(encode_reading(MountedReading(T_CAMERA_RING, RingReading(channels))))


@pytest.mark.parametrize(
    ("defect", "message"),
    [
        (lambda path: path.unlink(), "is missing"),
        (lambda path: path.write_bytes(path.read_bytes()[:-30]), "cannot be read"),
        (lambda path: put(path, ranges=np.zeros(8, np.float32)), "the manifest says ['echoes', 'ranges']"),
        (lambda path: put(path, ranges=np.zeros(8), echoes=np.arange(2)), "ranges is <f8 of shape (8,)"),
        (lambda path: put(path, ranges=np.zeros(9, np.float32), echoes=np.arange(2)), "<f4 of shape (9,)"),
        (lambda path: put(path, ranges=np.full(8, np.nan, np.float32), echoes=np.arange(2)), "not finite"),
        (lambda path: np.savez_compressed(path, ranges=np.zeros(8)), "is compressed"),
        (lambda path: (path.parent / "note.txt").touch(), "does not belong to the dataset"),
    ],
)
def test_validation_notices(made: Path, tmp_path: Path, defect, message: str) -> None:
    root = Path(shutil.copytree(made, tmp_path / "copy"))
    defect(root / "readings/ring/000002_000001.npz")
    (broken,) = [check for check in validate(root) if not check.ok]
    assert broken.name == "readings"
    assert message in broken.detail


def test_a_sensor_of_the_manifest_cannot_lead_out_of_the_folder(made: Path, tmp_path: Path) -> None:
    root = Path(shutil.copytree(made, tmp_path / "copy"))
    data = json.loads((root / "manifest.json").read_text())
    data["contents"]["readings"] = {"../../etc": data["contents"]["readings"]["ring"]}
    (root / "manifest.json").write_text(json.dumps(data))
    (check,) = validate(root)
    assert "the name of a sensor must be small letters" in check.detail


@pytest.mark.parametrize(
    ("channels", "message"),
    [
        ({"ranges": np.array([np.inf])}, "channel ranges has values that are not finite; give 0 for no reading"),
        ({"ranges": np.array(["a"])}, "channel 'ranges' must be a name with an array of numbers"),
        ({"T_camera_sensor": np.eye(4)}, "channel 'T_camera_sensor' must be a name"),
    ],
)
def test_what_cannot_be_stored_is_rejected(tmp_path: Path, channels: dict, message: str) -> None:
    with pytest.raises(DatasetError, match=f"sensor ring: {message}"):
        make(tmp_path / "data", lambda item: item.with_reading("ring", RingReading(channels)))


def test_a_sensor_gives_the_same_arrays_at_every_observation(tmp_path: Path) -> None:
    def changing(observation: Observation) -> Observation:
        kind = np.float32 if observation.observation_index else np.float64
        return observation.with_reading("ring", RingReading({"ranges": np.zeros(3, kind)}))

    with pytest.raises(DatasetError, match="sensor ring: channel ranges is not the same kind of array"):
        make(tmp_path / "data", changing)


def test_a_finished_dataset_is_taken_up_again(made: Path, tmp_path: Path) -> None:
    root = Path(shutil.copytree(made, tmp_path / "copy"))
    before = (root / "manifest.json").read_bytes()
    store = DatasetStore(root, replace(with_recipe(make_manifest(), RECIPE)))
    store.begin([PALLET], CAMERA, resume=True)
    store.finish()
    assert (root / "manifest.json").read_bytes() == before


def test_a_further_camera_is_stored_as_any_further_sensor(tmp_path: Path) -> None:
    def with_low(observation: Observation) -> Observation:
        return observation.with_reading("low", observation.rgbd, T_CAMERA_RING)

    reader = DatasetReader(make(tmp_path / "low", with_low))
    image = next(iter(reader.images("train")))
    ((name, item),) = reader.readings(image).items()
    gt = observe(make_scene(image.scene_id))[image.image_id].rgbd
    assert name == "low"
    assert np.array_equal(item.reading.channels["depth"], gt.depth)
    assert np.array_equal(item.reading.channels["rgb"], gt.rgb)
