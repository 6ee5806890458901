"""Write clouds: the sweep of each LiDAR and the coloured cloud of the camera, each in its own frame."""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from warehouse_sim.config import to_mapping
from warehouse_sim.dataset.files.json_file import write_json
from warehouse_sim.dataset.files.point_table import Table, camera_table, classes_of, sweep_table, sweeps_of
from warehouse_sim.dataset.files.record import camera_row
from warehouse_sim.dataset.formats.built_in import EachWriter, WriterBase, remove_folder
from warehouse_sim.dataset.formats.clouds import cloud_layout
from warehouse_sim.dataset.formats.clouds.pcd_cloud import encode_pcd
from warehouse_sim.dataset.formats.clouds.ply_cloud import encode_ply
from warehouse_sim.dataset.formats.observation_files import ObservationFiles
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.dataset.split import Split
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.output import make_folder, write_bytes
from warehouse_sim.schema import CAMERA, ObjectModel, Observation, SceneSpec
from warehouse_sim.schema.classes import class_number

ENCODERS: dict[str, Callable[[Table, str], bytes]] = {"ply": encode_ply, "pcd": encode_pcd}
"""How a format's name writes a table."""
_README = """# Point clouds

- {{train,val,test}}/SSSSSS/OOOOOO_SENSOR.{ending}: the cloud of a sensor of scene SSSSSS at observation OOOOOO, in the
  sensor's own frame, metres. OOOOOO.json beside it: where each sensor was, the camera, the class of each instance id.
- A LiDAR (x forward, y left, z up) has x y z intensity ring time instance_id label; only returns, in firing order;
  ring 0 is the topmost beam, time counts from the start of the sweep (s), intensity is 0-1.
- The camera (x right, y down, z forward) has x y z {color} instance_id label of every pixel with a depth reading, row
  by row, with the errors of its sensor.
- instance_id is that of ../scenes/, 0 = none; label is the number of the class, 0 = none, as in "classes".
- p_world = T_world_camera T_camera_sensor p_sensor, rows of 4x4 matrices. Pixel centres are integers.
"""
_COLORS = {"ply": "red green blue", "pcd": "rgb"}


class CloudWriter(WriterBase):
    """Write clouds as ``NAME/{train,val,test}/%06d/%06d_SENSOR.NAME``."""

    name: ClassVar[str]

    def __init__(self, root: Path, manifest: Manifest) -> None:
        super().__init__(root, manifest)
        self._layout = cloud_layout(root, self.name)

    def begin(self, models: Sequence[ObjectModel], camera: PinholeCamera) -> None:
        """Write the description."""
        make_folder(self._layout.root)
        text = _README.format(ending=self.name, color=_COLORS[self.name])
        write_bytes(self._layout.root / "README.md", text.encode("ascii"), durable=True)

    def scene(self, scene: SceneSpec) -> EachWriter:
        """Open a scene again."""
        split = self._manifest.split_of(scene.scene_index)
        folder = self._layout.scene(split, scene.scene_index)
        remove_folder(folder)
        make_folder(folder)
        return EachWriter(partial(self._write, split, scene))

    def _write(self, split: Split, scene: SceneSpec, files: ObservationFiles) -> None:
        """Write the clouds of one observation, and what is said of them."""
        observation = files.observation
        classes = classes_of(scene, observation.annotations)
        tables = {CAMERA: camera_table(observation, classes)}
        tables |= {name: sweep_table(item.reading, classes) for name, item in sweeps_of(observation).items()}
        place = split, observation.scene_index, observation.observation_index
        for name, table in tables.items():
            comment = f"metres, frame of the sensor {name}"
            write_bytes(self._layout.cloud(*place, name), ENCODERS[self.name](table, comment))
        present = sorted({int(number) for table in tables.values() for number in np.unique(table["instance_id"])} - {0})
        named = {number: classes[number] for number in present if number in classes}
        write_json(self._layout.description(*place), _description(observation, tables, named))


class PlyWriter(CloudWriter):
    """Write them as PLY."""

    name = "ply"


class PcdWriter(CloudWriter):
    """Write them as PCD."""

    name = "pcd"


def _description(observation: Observation, tables: dict[str, Table], classes: dict[int, str]) -> dict[str, Any]:
    view = observation.viewpoint
    row = {
        "scene": observation.scene_index,
        "observation": observation.observation_index,
        "sequence": None if view is None else view.sequence,
        "time": 0.0 if view is None else view.time,
        "T_world_camera": observation.T_world_camera,
        "T_world_vehicle": None if view is None else view.T_world_vehicle,
        "camera": camera_row(observation.camera),
        "sensors": {
            name: {"points": len(table), "T_camera_sensor": observation.readings[name].T_camera_sensor}
            for name, table in tables.items()
        },
        "instances": classes,
        "classes": {name: class_number(name) for name in sorted(set(classes.values()))},
    }
    description: dict[str, Any] = to_mapping(row)
    return description
