from pathlib import Path

import numpy as np
import pytest

from warehouse_sim.dataset.results import pose_csv
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.pose import make_transform, matrix_from_quat_wxyz
from warehouse_sim.schema import PoseEstimate

HEADER = "scene_id,im_id,obj_id,score,R,t,time"
ROW = "1,2,3,0.5,1 0 0 0 1 0 0 0 1,10 20 1000,-1"


def random_estimates(count: int) -> list[PoseEstimate]:
    rng = np.random.default_rng(5)
    R = matrix_from_quat_wxyz(rng.normal(size=(count, 4)))
    T = make_transform(R, rng.uniform(-10, 10, (count, 3)))
    return [PoseEstimate(i // 4, i // 2, 1 + i % 3, float(rng.random()), T[i], 0.125 * (i // 2)) for i in range(count)]


def test_round_trip_keeps_rotations_exactly_and_positions_to_a_rounding_step(tmp_path: Path) -> None:
    estimates = random_estimates(40)
    pose_csv.write(tmp_path / "new" / "preds.csv", estimates)
    for read, written in zip(pose_csv.read(tmp_path / "new" / "preds.csv"), estimates, strict=True):
        for key in ("scene_id", "image_id", "obj_id", "score", "time"):
            assert getattr(read, key) == getattr(written, key)
        assert np.array_equal(read.T_camera_object[:3, :3], written.T_camera_object[:3, :3])
        assert np.abs(read.T_camera_object - written.T_camera_object).max() < 1e-14


def test_file_is_what_the_bop_toolkit_expects(tmp_path: Path) -> None:
    T_camera_object = make_transform(None, np.array([0.25, -0.5, 4.0]))
    pose_csv.write(tmp_path / "a.csv", [PoseEstimate(7, 0, 1, 0.75, T_camera_object, -1.0)])
    header, row = (tmp_path / "a.csv").read_text().splitlines()
    assert header == HEADER
    cells = row.split(",")
    assert cells[:4] == ["7", "0", "1", "0.75"]
    assert [float(word) for word in cells[4].split(" ")] == [1, 0, 0, 0, 1, 0, 0, 0, 1]
    assert [float(word) for word in cells[5].split(" ")] == [250, -500, 4000]
    assert float(cells[6]) == -1


def test_no_estimates_is_a_file_with_a_header(tmp_path: Path) -> None:
    pose_csv.write(tmp_path / "a.csv", [])
    assert (tmp_path / "a.csv").read_text() == HEADER + "\n"
    assert pose_csv.read(tmp_path / "a.csv") == []


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ([], ":1: the header must be"),
        ([HEADER, ROW, ROW + ",1"], ":3: 7 fields separated by commas are expected, found 8"),
        ([HEADER, "", ROW], ":2: the line is blank"),
        ([HEADER, ROW.replace("0.5", "high")], ":2: score holds something else than numbers: 'high'"),
        ([HEADER, ROW.replace("1,2,3", "1,2.0,3")], ":2: scene_id, im_id and obj_id are whole numbers, found '2.0'"),
        ([HEADER, ROW.replace("1 0 0 0 1 0 0 0 1", "1 0 0 0 1 0 0 0")], ":2: R needs 9 numbers"),
        ([HEADER, ROW.replace("10 20 1000", "10 20")], ":2: t needs 3 numbers"),
        ([HEADER, ROW.replace("1 0 0 0 1 0 0 0 1", "1 0 0 0 1 0 0 0 -1")], ":2: R must be a rotation, found [1.0, "),
        ([HEADER, ROW.replace("1 0 0 0 1 0 0 0 1", " ".join(["1e300"] * 9))], ":2: R must be a rotation"),
        ([HEADER, ROW.replace("1000", "nan")], ":2: t must be finite, found '10 20 nan'"),
        ([HEADER, ROW.replace("1000", "1e300")], ":2: t is in millimetres and ends at 1e+07, found '10 20 1e300'"),
        ([HEADER, ROW.replace("0.5", "1_0")], ":2: score holds something else than numbers: '1_0'"),
        ([HEADER, ROW.replace("0.5", "٣")], ":2: score holds something else than numbers: '٣'"),
        ([HEADER, ROW.replace(",-1", ",1e999")], ":2: time must be finite, found '1e999'"),
        ([HEADER, ROW, ROW.replace("0.5", "0.6"), ROW], ":4: repeats line 2; remove one of the two"),
        ([HEADER, ROW, "x" * 100_000], ":3: has over 4096 characters"),
        (["PK\x03\x04" + "\0" * 10_000_000], ":1: the header must be"),
        ([HEADER, ROW, ROW.replace(",-1", ",0.3")], "the rows of scene 1, image 2 differ"),
    ],
)
def test_wrong_files_are_rejected_with_their_line(tmp_path: Path, lines: list[str], message: str) -> None:
    path = tmp_path / "preds.csv"
    path.write_text("\n".join(lines))
    with pytest.raises(DatasetError) as caught:
        pose_csv.read(path)
    assert message in str(caught.value)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 300 + len(str(path))


@pytest.mark.parametrize(
    "change",
    [
        lambda text: "\ufeff" + text,
        lambda text: text.replace("\n", "\r\n"),
        lambda text: text + "\n\n  \n",
        lambda text: text.rstrip("\n"),
        lambda text: "\ufeff" + text.replace("\n", "\r\n") + "\r\n\r\n",
    ],
)
def test_what_other_programs_do_to_the_text_of_a_file_changes_nothing(tmp_path: Path, change) -> None:
    pose_csv.write(tmp_path / "a.csv", random_estimates(5))
    (tmp_path / "b.csv").write_bytes(change((tmp_path / "a.csv").read_text()).encode("utf-8"))
    plain, changed = pose_csv.read(tmp_path / "a.csv"), pose_csv.read(tmp_path / "b.csv")
    for one, other in zip(plain, changed, strict=True):
        assert np.array_equal(one.T_camera_object, other.T_camera_object)
        assert (one.scene_id, one.score, one.time) == (other.scene_id, other.score, other.time)


def test_what_has_no_end_and_no_lines_is_rejected_at_once() -> None:
    with pytest.raises(DatasetError, match="/dev/zero:1: the header must be"):
        pose_csv.read(Path("/dev/zero"))


def test_missing_file_says_what_makes_it(tmp_path: Path) -> None:
    with pytest.raises(DatasetError, match="make it with warehouse-sim predict"):
        pose_csv.read(tmp_path / "none.csv")


def test_what_is_not_finite_is_not_written(tmp_path: Path) -> None:
    T_camera_object = make_transform(None, np.array([np.nan, 0.0, 1.0]))
    with pytest.raises(DatasetError, match="obj_id 4 in scene 1, image 2 is not finite"):
        pose_csv.write(tmp_path / "a.csv", [PoseEstimate(1, 2, 4, 1.0, T_camera_object)])
    assert not (tmp_path / "a.csv").exists()


@pytest.mark.parametrize("place", [0, 999, 1000, 1500])
def test_the_first_wrong_line_of_a_long_file_is_named_whatever_is_wrong_below(tmp_path: Path, place: int) -> None:
    rows = [ROW.replace("1,2,3", f"1,{number},3") for number in range(1600)]
    rows[place] = rows[place].replace("1 0 0 0 1 0 0 0 1", "2 0 0 0 2 0 0 0 2")
    rows[place + 1] = "no row"
    (tmp_path / "a.csv").write_text("\n".join([HEADER, *rows]))
    with pytest.raises(DatasetError, match=rf"a.csv:{place + 2}: R must be a rotation, found \[2.0, "):
        pose_csv.read(tmp_path / "a.csv")
    rows[place] = rows[0] if place else rows[1599]
    (tmp_path / "a.csv").write_text("\n".join([HEADER, *rows]))
    with pytest.raises(DatasetError, match=rf"a.csv:{place + 2 if place else 3}: (repeats|7 fields)"):
        pose_csv.read(tmp_path / "a.csv")
