"""MCAP recordings, read by mcap's own reader and decoded by their embedded schemas."""

import json
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

from tests.dataset.toy import CAMERA, PALLET, T_CAMERA_LIDAR, failures, make_dataset, make_manifest, make_scene, observe
from warehouse_sim.dataset.formats.mcap.checks import cloud_of, pose_in_root, read_moments, transforms_of
from warehouse_sim.dataset.formats.mcap.messages import calibration_message
from warehouse_sim.dataset.formats.mcap.writer import EPOCH, SceneClock
from warehouse_sim.dataset.store import DatasetStore
from warehouse_sim.dataset.stored.scene_record import Outcome
from warehouse_sim.dataset.validate import validate
from warehouse_sim.errors import DatasetError, MissingPackageError
from warehouse_sim.geometry.lens import Fisheye
from warehouse_sim.geometry.pose import level_camera
from warehouse_sim.schema import ChannelReading, Conditions, Observation, Viewpoint

SECOND = 1_000_000_000
MCAP = make_manifest(formats=("mcap",))


def messages(path: Path) -> dict[str, list[tuple[int, Any]]]:
    """Return time and content of the messages of each topic."""
    found: dict[str, list[tuple[int, Any]]] = {}
    with open(path, "rb") as stream:
        decoders = DecoderFactory()
        for schema, channel, message in make_reader(stream, validate_crcs=True).iter_messages():
            decode = decoders.decoder_for(channel.message_encoding, schema) or json.loads
            found.setdefault(channel.topic, []).append((message.log_time, decode(message.data)))
    return found


def write(root: Path, observations: list[Observation]) -> Path:
    """Write one scene of these observations and return its file."""
    numbered = [replace(item, observation_index=i) for i, item in enumerate(observations)]
    store = DatasetStore(root, replace(make_manifest(1, ("mcap",)), observations_per_scene=len(numbered)))
    store.begin([PALLET], CAMERA)
    store.write_scene(make_scene(0), numbered, Outcome({"problems": [], "speed": 0.0}, "none"))
    store.finish()
    return root / "mcap" / "train" / "000000.mcap"


def test_a_recording_holds_what_was_read(streams_root: Path) -> None:
    found = messages(streams_root / "mcap" / "train" / "000000.mcap")
    topics = [
        "camera/image",
        "camera/depth",
        "camera/calibration",
        "camera/boxes",
        "lidar/points",
        "objects",
        "conditions",
        "tf",
    ]
    assert set(found) == {f"/{name}" for name in topics}
    with open(streams_root / "mcap" / "train" / "000000.mcap", "rb") as stream:
        header = make_reader(stream).get_header()
    assert (header.profile, header.library) == ("", "warehouse-sim")
    for index, observation in enumerate(observe(make_scene(0))):
        (stamp, image), (_, depth), (_, cloud) = (
            found[name][index] for name in ("/camera/image", "/camera/depth", "/lidar/points")
        )
        assert stamp == (EPOCH + index) * SECOND
        assert image.timestamp.ToNanoseconds() == stamp
        pixels = cv2.imdecode(np.frombuffer(image.data, np.uint8), cv2.IMREAD_COLOR)[..., ::-1]
        np.testing.assert_array_equal(pixels, observation.rgbd.rgb)
        assert (depth.encoding, depth.step) == ("32FC1", 4 * CAMERA.width)
        metres = np.frombuffer(depth.data, "<f4").reshape(depth.height, depth.width)
        np.testing.assert_array_equal(metres, observation.rgbd.depth)
        scan, rows = observation.lidar, np.frombuffer(cloud.data, "<f4").reshape(-1, cloud.point_stride // 4)
        assert scan is not None
        offsets = {item.name: item.offset // 4 for item in cloud.fields}
        np.testing.assert_array_equal(rows[:, [offsets[name] for name in "xyz"]], scan.points)
        np.testing.assert_array_equal(rows[:, offsets["time"]], scan.time)
        np.testing.assert_array_equal(rows.view("<i4")[:, offsets["instance_id"]], scan.instance_ids)


def test_frames_lead_from_the_world_to_each_sensor(streams_root: Path) -> None:
    found = messages(streams_root / "mcap" / "train" / "000000.mcap")
    for (_, message), observation in zip(found["/tf"], observe(make_scene(0)), strict=True):
        frames = transforms_of(message)
        assert {name: parent for name, (parent, _) in frames.items()} == {
            "rig": "world",
            "camera": "rig",
            "lidar": "camera",
        }
        T_world_lidar = observation.T_world_camera @ T_CAMERA_LIDAR
        np.testing.assert_allclose(pose_in_root(frames, "lidar"), T_world_lidar, rtol=0, atol=1e-9)


def test_boxes_are_those_of_the_labels(streams_root: Path) -> None:
    found = messages(streams_root / "mcap" / "train" / "000000.mcap")
    labels = [item for item in observe(make_scene(0))[0].annotations if item.pixels_visible]
    (_, update), (_, outlines) = found["/objects"][0], found["/camera/boxes"][0]
    assert [entity.id for entity in update.entities] == [str(item.instance_id) for item in labels]
    for entity, label in zip(update.entities, labels, strict=True):
        cube, words = entity.cubes[0], {item.key: item.value for item in entity.metadata}
        assert [cube.size.x, cube.size.y, cube.size.z] == label.size.tolist()
        place = cube.pose.position
        np.testing.assert_array_equal([place.x, place.y, place.z], label.T_camera_object[:3, 3])
        assert (words["class_name"], words["obj_id"]) == ("pallet", "1")
        assert entity.frame_id == "camera"
        box = next(
            [(p.x, p.y) for p in item.points]
            for item in outlines.points
            if {m.key: m.value for m in item.metadata}.items()
            >= {"box": "visible", "instance_id": str(label.instance_id)}.items()
        )
        # From the outer corner of the first pixel: around the pixels, not through their centres.
        left, top, right, bottom = label.box_visible_xyxy or (0, 0, 0, 0)
        assert box == [(left, top), (right + 1, top), (right + 1, bottom + 1), (left, bottom + 1)]
    # The second camera sees nothing: what was there goes away.
    assert not found["/objects"][1][1].entities
    assert found["/objects"][1][1].deletions[0].type == 1


def view(time: float, sequence: int | None) -> Viewpoint:
    return Viewpoint(level_camera(np.zeros(3), 0.0), time=time, sequence=sequence)


def test_stamps_go_with_the_drive_and_paired_variants_share_one() -> None:
    first = observe(make_scene(0))[0]
    moments = [(view(0.0, 0), None, "base"), (view(0.25, 0), None, "base"), (view(3.0, 1), None, "base")]
    moments += [(view(3.5, 1), 7, "base"), (view(3.5, 1), 7, "dark"), (view(0.0, None), None, "base")]
    clock = SceneClock(2)
    stamps = [
        clock.stamp(
            replace(first, viewpoint=place, conditions=Conditions(variant_group=paired_variants, variant=variant))
        )
        for place, paired_variants, variant in moments
    ]
    start = (EPOCH + 2 * 3600) * SECOND
    assert [(stamp - start) / SECOND for stamp in stamps] == [0.0, 0.25, 1.25, 1.75, 1.75, 2.75]


def test_paired_variants_and_other_sensors_have_topics_of_their_own(tmp_path: Path) -> None:
    first = observe(make_scene(0))[0]
    accel = np.array([0.1, -9.8, 1 / 3])
    first = first.with_reading("imu", ChannelReading({"accel": accel}, {"accel": "m/s^2"}))
    vehicle = level_camera(np.array([0.5, 0.0, 0.0]), 0.3)
    first = replace(first, viewpoint=Viewpoint(first.T_world_camera, T_world_vehicle=vehicle, time=2.0, sequence=4))
    paired_variants = [
        replace(first, conditions=Conditions(variant_group=0, variant=name, floor_lux=lux))
        for name, lux in (("base", 300.0), ("dark", 20.0))
    ]
    path = write(tmp_path / "data", paired_variants)
    found = messages(path)
    assert {"/camera/image", "/dark/camera/image", "/imu/reading", "/dark/imu/reading"} <= found.keys()
    assert len(found["/tf"]) == 1
    ((_, reading),) = found["/imu/reading"]
    assert (reading["accel"], reading["frame_id"]) == (accel.tolist(), "imu")
    assert json.loads(found["/dark/conditions"][0][1].message)["floor_lux"] == 20.0
    frames = transforms_of(found["/tf"][0][1])
    np.testing.assert_allclose(frames["rig"][1], vehicle, atol=1e-12)
    np.testing.assert_allclose(pose_in_root(frames, "camera"), first.T_world_camera, atol=1e-9)
    assert all(check.ok for check in validate(tmp_path / "data") if check.name.startswith("mcap"))


def test_lenses_have_their_names_and_pairs_their_baseline() -> None:
    lens = Fisheye(0.1, -0.02, 0.003, -0.0004)
    message = calibration_message(0, "camera", replace(CAMERA, distortion=lens))
    assert (message.distortion_model, list(message.D)) == ("kannala_brandt", [0.1, -0.02, 0.003, -0.0004])
    message = calibration_message(0, "right", CAMERA, baseline=0.5)
    assert (message.distortion_model, list(message.D)) == ("plumb_bob", [0.0] * 5)
    assert list(message.K) == CAMERA.K.ravel().tolist()
    assert np.array(message.P).reshape(3, 4)[0].tolist() == [CAMERA.fx, 0.0, CAMERA.cx, -CAMERA.fx * 0.5]


def test_without_the_packages_nothing_is_made(tmp_path: Path, monkeypatch) -> None:
    class Blocked:
        def find_spec(self, name: str, path: object = None, target: object = None) -> None:
            if name.partition(".")[0] == "foxglove_schemas_protobuf":
                raise ModuleNotFoundError(name)

    monkeypatch.setattr(sys, "meta_path", [Blocked(), *sys.meta_path])
    for name in [name for name in sys.modules if name.startswith("foxglove_schemas_protobuf")]:
        monkeypatch.delitem(sys.modules, name)
    with pytest.raises(MissingPackageError, match=r"pip install 'warehouse-sim\[mcap\]'"):
        make_dataset(tmp_path / "data", MCAP)
    assert not (tmp_path / "data").exists()


def test_a_scene_that_was_broken_off_is_written_again(tmp_path: Path) -> None:
    store = DatasetStore(tmp_path, MCAP)
    store.begin([PALLET], CAMERA)

    def breaks_off():
        yield observe(make_scene(0))[0]
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        store.write_scene(make_scene(0), breaks_off(), Outcome({}, "none"))
    folder = tmp_path / "mcap" / "train"
    assert not (folder / "000000.mcap").exists()
    store.write_scene(make_scene(0), observe(make_scene(0)), Outcome({"problems": []}, "none"))
    assert [path.name for path in folder.iterdir()] == ["000000.mcap"]


def test_validate_finds_what_is_cut_changed_or_missing(streams_root: Path, tmp_path: Path) -> None:
    assert all(check.ok for check in validate(streams_root))
    copy = make_dataset(tmp_path / "data", MCAP)
    path = copy / "mcap" / "train" / "000000.mcap"
    whole = path.read_bytes()
    changed = bytearray(whole)
    changed[len(whole) // 3] ^= 1
    other = (copy / "mcap" / "val" / "000001.mcap").read_bytes()
    for content, words in (
        (whole[:-100], "cannot be read"),
        (bytes(changed), "cannot be read"),
        (other, "off its place"),
    ):
        path.write_bytes(content)
        (problem,) = failures(copy).values()
        assert str(path) in problem
        assert words in problem
    path.unlink()
    assert list(failures(copy)) == ["mcap files", "mcap messages"]


@pytest.mark.parametrize("content", [b"", b"\x89MCAP0\r\n", b"x" * 100, b"\x89MCAP0\r\n" + b"\xff" * 200])
def test_what_is_no_recording_is_rejected(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "a.mcap"
    path.write_bytes(content)
    with pytest.raises(DatasetError, match="cannot be read"):
        list(read_moments(path))


def test_a_cloud_that_does_not_fit_its_fields_is_rejected(streams_root: Path) -> None:
    moment = next(read_moments(streams_root / "mcap" / "train" / "000000.mcap"))
    cloud = moment.messages["/lidar/points"]
    assert len(cloud_of(cloud)) * cloud.point_stride == len(cloud.data)
    cloud.point_stride = 31
    with pytest.raises(DatasetError, match="does not fit"):
        cloud_of(cloud)
