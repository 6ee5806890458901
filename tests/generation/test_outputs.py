"""What a recipe wants is what is made: every subset holds the very bytes of the whole dataset, and can be trusted."""

import json
import shutil
import tarfile
from dataclasses import replace
from pathlib import Path

import pytest

from tests.dataset.convert.test_same_files import rounded
from tests.dataset.faults.folder import linked_copy
from tests.shared import Shared, hashes
from warehouse_sim.dataset.convert.run import convert
from warehouse_sim.dataset.manifest import read_manifest
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.validate import validate
from warehouse_sim.errors import DatasetError, RecipeError
from warehouse_sim.generation.generate import generate
from warehouse_sim.generation.plan import GenerateConfig, default_formats, plan_dataset
from warehouse_sim.generation.recipe import Recipe, changed, load_recipe
from warehouse_sim.sensors import SENSORS

FORMATS = ("bop", "bop_webdataset", "bop_compact")
WHOLE = ("default", "clean")
FOLDERS = {
    "rgb": ("rgb",),
    "depth": ("depth",),
    "masks": ("mask_visib", "scene_gt_coco.json"),
    "amodal_masks": ("mask",),
    "clean": ("rgb_clean", "depth_clean"),
    "poses": ("scene_gt.json", "scene_gt_info.json", "scene_camera.json"),
}
SUBSETS = (
    ("rgb", "depth", "masks", "poses"),
    ("depth", "masks", "poses"),
    ("rgb", "poses"),
    ("poses",),
    ("masks", "amodal_masks", "poses"),
    ("depth", "amodal_masks", "poses", "clean"),
)
SAID = ("manifest.json", "SHA256SUMS", "README.md", "card/", "dataset_info.md")
"""What says what was left out, and the pictures of the card, which show depth where there is no colour."""


def wanting(shared: Shared, *outputs: str) -> Recipe:
    return changed(load_recipe(str(shared.small)), {"sensors": {"outputs": list(outputs)}})


def made(shared: Shared, *outputs: str) -> Path:
    return shared.dataset(wanting(shared, *outputs), scenes=1, seed=3, formats=FORMATS)


def contents(root: Path) -> dict[str, object]:
    """Return the hash of each file, the bytes of each member of a shard, and records but for other readings."""
    found: dict[str, object] = dict(hashes(root))
    for path in root.rglob("*.tar"):
        del found[str(path.relative_to(root))]
        with tarfile.open(path) as archive:
            for member in archive:
                file = archive.extractfile(member)
                found[f"{path.relative_to(root)}/{member.name}"] = file and file.read()
    for path in (root / "scenes").iterdir():
        record = json.loads(path.read_text(encoding="utf-8"))
        found[f"scenes/{path.name}"] = {key: value for key, value in record.items() if key != "readings"}
    return {name: value for name, value in found.items() if not any(part in name for part in SAID)}


@pytest.mark.parametrize("outputs", SUBSETS, ids=" ".join)
def test_what_is_left_out_changes_no_byte_of_what_is_made(shared: Shared, outputs: tuple[str, ...]) -> None:
    part, whole = contents(made(shared, *outputs)), contents(made(shared, *WHOLE))
    assert part.items() <= whole.items()
    for name, folders in FOLDERS.items():
        for folder in folders:
            shown = [path for path in part if f"/{folder}/" in path or f"{folder}." in path or path.endswith(folder)]
            assert bool(shown) == (name in outputs), folder


@pytest.mark.parametrize("outputs", [WHOLE, *SUBSETS], ids=" ".join)
def test_a_subset_passes_validation_until_a_promised_file_is_gone(
    shared: Shared, outputs: tuple[str, ...], tmp_path: Path
) -> None:
    root = made(shared, *outputs)
    checks = validate(root)
    assert [check.detail for check in checks if not check.ok] == []
    manifest = read_manifest(root)
    assert {name for name in manifest.contents.outputs if name in FOLDERS} == {
        *outputs, *(("rgb", "depth", "masks", "amodal_masks", "poses") if "default" in outputs else ())
    } - {"default"}  # fmt: skip
    (scene,) = (root / "bop/train").glob("000000")
    for promised in sorted(path.name for path in scene.iterdir()):
        broken = linked_copy(root, tmp_path / promised)
        path = broken / "bop/train/000000" / promised
        (next(path.iterdir()) if path.is_dir() else path).unlink()
        assert [check.name for check in validate(broken) if not check.ok]
        shutil.rmtree(broken)


def test_what_is_left_out_cannot_be_smuggled_in(shared: Shared, tmp_path: Path) -> None:
    root = tmp_path / "data"
    shutil.copytree(made(shared, "rgb", "poses"), root)
    (root / "bop/train/000000/depth").mkdir()
    assert [check.name for check in validate(root) if not check.ok] == ["bop files"]


def test_readers_say_what_was_left_out_and_how_to_have_it(shared: Shared) -> None:
    reader = DatasetReader(made(shared, "poses"))
    image = reader.images("train")[0]
    assert not reader.has_depth
    assert reader.rgb_file(image) is None
    for read, name in ((reader.rgb, "rgb"), (reader.depth, "depth")):
        with pytest.raises(DatasetError, match=f"holds no {name}; generate it with --outputs"):
            read(image)
    for of_target, name in ((reader.mask_visible, "masks"), (reader.mask, "amodal_masks")):
        with pytest.raises(DatasetError, match=f"holds no {name}; generate it with --outputs"):
            of_target(image, 0)


def test_conversion_says_what_it_lacks(shared: Shared, tmp_path: Path) -> None:
    for outputs, name, lacking in (
        (("rgb", "depth", "masks", "poses"), "linemod", "amodal_masks"),
        (("rgb", "poses"), "coco", "depth, masks"),
        (("rgb", "poses"), "ply", "depth, masks"),
        (("masks", "amodal_masks", "poses"), "yolo", "rgb, depth"),
    ):
        with pytest.raises(DatasetError, match=f"without {lacking}, which {name} is made of; .* with {name} among"):
            convert(made(shared, *outputs), tmp_path / name, (name,))
        assert not (tmp_path / name).exists()


@pytest.mark.parametrize(
    ("outputs", "formats"),
    [(("rgb", "depth", "masks", "poses", "clean"), ("yolo", "coco", "ply")), (("rgb", "depth", "poses"), ("mcap",))],
)
def test_what_is_there_is_converted(
    shared: Shared, tmp_path: Path, outputs: tuple[str, ...], formats: tuple[str, ...]
) -> None:
    recipe = wanting(shared, *outputs)
    generate(recipe, tmp_path / "then", GenerateConfig(scenes=1, seed=3, formats=("bop",)))
    convert(tmp_path / "then", tmp_path / "converted", formats)
    if "yolo" in formats:
        generate(recipe, tmp_path / "at_once", GenerateConfig(scenes=1, seed=3, formats=("bop", *formats)))
        roots = [tmp_path / name for name in ("converted", "at_once")]
        one, other = (hashes(root / "yolo") for root in roots)
        assert one == other
        tables = [json.loads((root / "coco/annotations/instances_train.json").read_text()) for root in roots]
        assert rounded(tables[0]) == rounded(tables[1])  # poses go through millimetres
    assert [check.detail for check in validate(tmp_path / "converted") if not check.ok] == []


def test_lidars_rest_where_no_format_holds_a_sweep(
    shared: Shared, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def read(*_: object) -> None:
        raise AssertionError("the LiDAR reads")

    monkeypatch.setattr(SENSORS.get("lidar"), "read", read)
    recipe = wanting(shared)
    assert recipe.sensors.lidar is not None
    generate(recipe, tmp_path / "data", GenerateConfig(scenes=1, formats=("bop", "coco")))
    assert [check.detail for check in validate(tmp_path / "data") if not check.ok] == []
    with pytest.raises(AssertionError, match="the LiDAR reads"):
        generate(recipe, tmp_path / "clouds", GenerateConfig(scenes=1, formats=("ply",)))


@pytest.mark.parametrize(
    ("outputs", "name", "lacking"),
    [
        (("rgb", "depth", "masks", "poses"), "kitti", "lidar"),
        (("poses", "lidar"), "ply", "rgb, depth"),
        (("rgb", "depth", "poses"), "coco", "masks"),
        (("rgb", "depth", "poses"), "yolo", "masks"),
        (("rgb", "masks", "poses"), "linemod", "depth"),
    ],
)
def test_a_format_names_what_it_cannot_do_without(
    shared: Shared, outputs: tuple[str, ...], name: str, lacking: str
) -> None:
    with pytest.raises(DatasetError, match=f"outputs: {lacking} is left out, which {name} needs; add it, or leave"):
        plan_dataset(wanting(shared, *outputs), GenerateConfig(formats=("bop", name)))


def test_coco_without_amodal_masks_lacks_their_table_alone(shared: Shared) -> None:
    outputs, formats = ("rgb", "depth", "masks", "poses"), ("bop", "coco", "yolo", "linemod")
    part = shared.dataset(wanting(shared, *outputs), scenes=1, seed=3, formats=formats)
    whole = shared.dataset(wanting(shared), scenes=1, seed=3, formats=formats)
    assert [check.detail for check in validate(part) if not check.ok] == []
    assert contents(part).items() <= contents(whole).items()
    gone = {name for name in contents(whole) if name not in contents(part)}
    gone = {name for name in gone if not name.startswith("readings/")}
    assert {("instances_amodal" in name, "/mask/" in name) for name in gone} == {(True, False), (False, True)}


def test_formats_by_default_fit_the_outputs(shared: Shared) -> None:
    assert default_formats(wanting(shared)) == ("kitti", "bop")
    assert default_formats(wanting(shared, "default", "clean")) == ("kitti", "bop")
    assert default_formats(wanting(shared, "rgb", "depth", "masks", "poses")) == ("bop",)


@pytest.mark.parametrize(
    ("outputs", "says"),
    [
        (("rgb", "depht", "poses"), "did you mean 'depth'"),
        (("rgb", "depth"), "outputs must hold poses"),
        (("poses", "poses"), "must name each once"),
        (("poses", "right"), "right is wanted, but the rig has no such sensor"),
    ],
)
def test_a_wish_that_cannot_be_met_is_one_clear_line(shared: Shared, outputs: tuple[str, ...], says: str) -> None:
    with pytest.raises(RecipeError, match=says) as problem:
        wanting(shared, *outputs)
    assert "outputs" in str(problem.value)
    assert "\n" not in str(problem.value)


def test_an_output_needs_a_format_with_a_place_for_it(shared: Shared) -> None:
    with pytest.raises(DatasetError, match=r"outputs: lidar has no place in bop; add kitti or .* to --formats"):
        plan_dataset(wanting(shared, "poses", "lidar"), GenerateConfig(formats=("bop",)))
    plan_dataset(wanting(shared, "default", "clean"), GenerateConfig(formats=("bop",)))


def test_a_recipe_that_wants_nothing_says_nothing(shared: Shared) -> None:
    plan = plan_dataset(wanting(shared), GenerateConfig(formats=("bop",)))
    assert "outputs" not in plan.manifest.recipe["sensors"]
    assert plan.manifest.contents == replace(plan.manifest.contents, left_out=())
