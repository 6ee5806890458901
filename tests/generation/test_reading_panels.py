from pathlib import Path

import cv2
import numpy as np

from tests.shared import Shared
from warehouse_sim.generation.contact_sheet import reading_panels, render_contact_sheet
from warehouse_sim.generation.recipe import changed, load_recipe
from warehouse_sim.schema import ChannelReading, MountedReading


def panel_of(**channels: np.ndarray) -> tuple[str, np.ndarray]:
    ((caption, panel),) = reading_panels(
        {"ring": MountedReading(np.eye(4), ChannelReading(channels))}, (240, 320)
    ).items()
    return caption, panel


def test_the_caption_names_sensor_and_channels() -> None:
    caption, panel = panel_of(distance=np.ones(4), echo=np.zeros(4))
    assert caption == "ring: distance, echo"
    assert panel.shape == (240, 320, 3)


def test_a_longer_distance_is_a_higher_bar() -> None:
    _, panel = panel_of(distance=np.array([1.0, 2.0, 4.0, np.inf]))
    lit = (panel == (90, 170, 230)).all(axis=2).sum(axis=0)
    bars = [int(lit[40 + 80 * number]) for number in range(4)]
    assert bars[2] > 100
    np.testing.assert_allclose(bars[:2], [bars[2] / 4, bars[2] / 2], atol=1)
    assert bars[3] == 0


def test_an_image_is_shown_as_it_is() -> None:
    rgb = np.random.default_rng(0).integers(0, 256, (240, 320, 3)).astype(np.uint8)
    assert np.array_equal(panel_of(rgb=rgb)[1], rgb)


def test_what_cannot_be_drawn_is_told_in_words() -> None:
    for values in (np.zeros(0), np.zeros((5, 3)), np.array(["a", "b"]), np.full(3, np.nan), np.float64(2.0)):
        _, panel = panel_of(odd=values)
        assert (panel > 200).any()


def test_a_rig_without_lidar_has_no_panels_of_it(shared: Shared, tmp_path: Path) -> None:
    recipe, rows = load_recipe(str(shared.small)), list[float]()
    assert recipe.sensors.lidar is not None
    for given in (recipe, changed(recipe, {"sensors": {"lidar": None}})):
        render_contact_sheet(given, 3, 0, tmp_path / "sheet.png")
        rows.append(cv2.imread(str(tmp_path / "sheet.png")).shape[0] / given.sensors.camera.height)
    assert rows[1] == rows[0] - 1
