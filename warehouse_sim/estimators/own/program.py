"""An estimator that is another program: one JSON line an image in, one JSON line a pose out, in any language."""

import contextlib
import ctypes
import json
import os
import queue
import shlex
import signal
import subprocess
import sys
import tempfile
import threading
import time
import weakref
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from warehouse_sim.dataset.files.image_io import encode_depth, encode_mask, encode_rgb, farthest_depth
from warehouse_sim.dataset.files.ply import write_ply
from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.results.pose_csv import estimate_fault
from warehouse_sim.errors import InputError, shown
from warehouse_sim.estimators.api import PoseEstimator
from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.schema import PoseEstimate

PROGRAM = "exec:"
"""What the name of an estimator begins with that is a program."""
STEPS_PER_METRE = 2000.0
"""Of the depth images that a program gets: half a millimetre a step, to 32.7 m."""
_PR_SET_PDEATHSIG = 1
_MOST_CHARACTERS = 100_000


class TooSlowError(InputError):
    """A program did not answer within its time, and was ended."""


class ProgramEstimator(PoseEstimator):
    """Starts a program once and asks it image by image; docs/estimators.md states the lines.

    Args:
        command: The program and its arguments, as a shell splits them; no shell runs.
        timeout: Seconds that it may take for an image, the first one with its start.

    Raises:
        InputError: It cannot be started.
    """

    learns_objects = True
    reads_depth = False

    def __init__(self, command: str, timeout: float = 60.0) -> None:
        words = words_of(command)
        self.__name__, self._called = Path(words[0]).name, f"program {shown(command)}"
        self._timeout, self._line = timeout, 0
        self._folder = tempfile.TemporaryDirectory(prefix="warehouse-sim-")
        self._numbers: dict[str, int] = {}
        self._objects: list[dict[str, Any]] = []
        try:
            self._process = subprocess.Popen(
                words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1, errors="replace",
                preexec_fn=_end_with_parent if sys.platform == "linux" else None,
            )  # fmt: skip
        except OSError as problem:
            raise InputError(f"--exec {command}: cannot be started ({problem.strerror}); check the path") from None
        self._answers: queue.Queue[str | None] = queue.Queue()
        self._end = weakref.finalize(self, _end, self._process, self._folder)
        threading.Thread(
            target=_listen, args=(self._process, self._answers), name=f"answers of {self.__name__}", daemon=True
        ).start()

    def onboard(self, objects: Mapping[int, ObjectInfo]) -> None:
        """Learn the numbers of a dataset's objects by name, for poses that name one, and hand out their CAD."""
        self._numbers = {info.name: number for number, info in objects.items()}
        self._objects = [self._object(info) for info in objects.values()]

    def estimate(self, image: RgbdImage) -> list[PoseEstimate]:
        """Return the poses that the program gives for an image.

        Raises:
            InputError: It ends, takes too long, or a line of it is no pose.
        """
        started = time.monotonic()
        self._send(image)
        found = [self._pose(line, number, image) for number, line in self._lines(image, started + self._timeout)]
        return found

    @property
    def is_ended(self) -> bool:
        """Whether it ended, by itself or because it took too long."""
        return self._process.poll() is not None

    def close(self) -> None:
        """End the program and remove its files."""
        self._end()

    def _send(self, image: RgbdImage) -> None:
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(json.dumps(self._question(image)) + "\n")
            self._process.stdin.flush()
        except OSError:
            raise self._ended() from None

    def _question(self, image: RgbdImage) -> dict[str, Any]:
        camera, folder = image.camera, Path(self._folder.name)
        depth = np.where(image.depth > farthest_depth(STEPS_PER_METRE), np.float32(0), image.depth)
        files = {"depth": encode_depth(depth, STEPS_PER_METRE, "--exec")}
        if image.rgb is not None:
            files["rgb"] = encode_rgb(image.rgb)
        shown_masks = {f"mask_{i}": item.mask for i, item in enumerate(image.detections)}
        masks = {name: encode_mask(mask) for name, mask in shown_masks.items() if mask is not None}
        for name, content in (files | masks).items():
            (folder / f"{name}.png").write_bytes(content)
        lens = camera.distortion
        terms = {} if lens is None else {key: float(value) for key, value in vars(lens).items()}
        return {
            "scene_id": image.scene_id,
            "image_id": image.image_id,
            "width": camera.width,
            "height": camera.height,
            "K": [[camera.fx, 0.0, camera.cx], [0.0, camera.fy, camera.cy], [0.0, 0.0, 1.0]],
            "distortion": None if lens is None else {"model": type(lens).__name__, **terms},
            "rgb": str(folder / "rgb.png") if image.rgb is not None else None,
            "depth": str(folder / "depth.png"),
            "depth_scale": 1.0 / STEPS_PER_METRE,
            "objects": self._objects,
            "detections": [self._detection(item, i) for i, item in enumerate(image.detections)],
        }

    def _object(self, info: ObjectInfo) -> dict[str, Any]:
        """Return what a program learns about an object; the mesh, where there is CAD, is in millimetres, as BOP's."""
        mesh = Path(self._folder.name) / f"obj_{info.obj_id:06d}.ply" if info.has_cad else None
        if mesh is not None:
            surface = info.mesh()
            write_ply(mesh, TriangleMesh(1000.0 * surface.vertices, surface.faces))
        return {
            "obj_id": info.obj_id,
            "name": info.name,
            "class_name": info.class_name,
            "diameter": info.diameter,
            "mesh": None if mesh is None else str(mesh),
        }

    def _detection(self, item: Detection, position: int) -> dict[str, Any]:
        names = {number: name for name, number in self._numbers.items()}
        name = names.get(item.model) if isinstance(item.model, int) else item.model
        return {
            "detection": item.number_at(position),
            "name": name,
            "class_name": item.class_name or None,
            "score": item.score,
            "box_xyxy": None if item.box_xyxy is None else list(map(float, item.box_xyxy)),
            "mask": None if item.mask is None else str(Path(self._folder.name) / f"mask_{position}.png"),
        }

    def _lines(self, image: RgbdImage, until: float) -> Iterator[tuple[int, dict[str, Any]]]:
        """Yield the program's lines until it says that the image is done."""
        while True:
            try:
                line = self._answers.get(timeout=max(0.0, until - time.monotonic()))
            except queue.Empty:
                self._process.kill()
                self._process.wait()
                raise TooSlowError(
                    f"{self._called}: no answer to scene {image.scene_id}, image {image.image_id} within "
                    f"{self._timeout:g} s; end each image with an empty line, or raise --exec-timeout"
                ) from None
            if line is None:
                raise self._ended()
            self._line += 1
            if not line.strip():
                return
            try:
                row = json.loads(line)
            except (ValueError, RecursionError):
                row = None
            if not isinstance(row, dict):
                raise self._bad("is no JSON object", line)
            if row.get("end"):
                return
            yield self._line, row

    def _pose(self, row: dict[str, Any], number: int, image: RgbdImage) -> PoseEstimate:
        try:
            R, t = np.asarray(row["R"], dtype=float), np.asarray(row["t"], dtype=float)
            T = np.eye(4)
            T[:3, :3], T[:3, 3] = R.reshape(3, 3), t.reshape(3)
            detection = int(row.get("detection", -1))
            obj_id = self._number(row, detection, image)
            score = float(row.get("score", 1.0))
        except (KeyError, TypeError, ValueError, OverflowError) as problem:
            raise self._bad(f"lacks a key or has a wrong value ({type(problem).__name__}: {problem})", row) from None
        estimate = PoseEstimate(image.scene_id, image.image_id, obj_id, score, T, detection=detection)
        if (fault := estimate_fault(estimate)) is not None:
            raise self._bad(fault, row)
        return estimate

    def _number(self, row: Mapping[str, Any], detection: int, image: RgbdImage) -> int:
        """Return the obj_id that a line means: by number, by name, or that of its detection."""
        if "obj_id" in row:
            return int(row["obj_id"])
        name = row.get("name")
        if name is None:
            models = {item.number_at(i): item.model for i, item in enumerate(image.detections)}
            name = models.get(detection)
        if isinstance(name, int):
            return name
        if name not in self._numbers:
            raise ValueError(f"name {shown(name)} is none of {', '.join(sorted(self._numbers)) or 'the objects'}")
        return self._numbers[name]

    def _bad(self, why: str, line: Any) -> InputError:
        text = line.strip() if isinstance(line, str) else json.dumps(line)
        return InputError(f"{self._called}: line {self._line} {why}: {shown(text)}")

    def _ended(self) -> InputError:
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(timeout=2.0)
        return InputError(
            f"{self._called}: ended with exit code {self._process.returncode} before all images; "
            "it must read lines until its input ends"
        )


def _listen(process: "subprocess.Popen[str]", answers: "queue.Queue[str | None]") -> None:
    assert process.stdout is not None
    while line := process.stdout.readline(_MOST_CHARACTERS):
        answers.put(line)
    answers.put(None)


def _end(process: "subprocess.Popen[str]", folder: "tempfile.TemporaryDirectory[str]") -> None:
    """End a program, which has two seconds after its input ends, and remove its files."""
    with contextlib.suppress(OSError):
        if process.stdin is not None:
            process.stdin.close()
    try:
        process.wait(timeout=2.0)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
    folder.cleanup()


def words_of(command: str) -> list[str]:
    """Return the program and its arguments, as a shell splits them.

    Raises:
        InputError: There are none, or a quotation has no end.
    """
    try:
        words = shlex.split(command)
    except ValueError as problem:
        raise InputError(f"--exec {shown(command)}: {problem}") from None
    if not words:
        raise InputError("--exec names no program")
    return words


def _end_with_parent() -> None:
    """Let the system end the program with this process, however that ends."""
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() == 1:
        os._exit(1)
