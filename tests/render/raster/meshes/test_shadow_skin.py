import numpy as np

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.materials import materials
from warehouse_sim.render.conformance.scenes import MATERIALS, box_part
from warehouse_sim.render.raster.meshes.parts import shadow_casters
from warehouse_sim.schema import ObjectModel, Part


def model(*parts: Part) -> ObjectModel:
    return ObjectModel("m", "carton", 1, np.ones(3), parts, ())


def test_skin_on_a_box_casts_nothing_and_what_stands_out_does() -> None:
    body = box_part((0.6, 0.4, 0.3), material="kraft")
    tape = box_part((0.601, 0.05, 0.301))
    handle = box_part((0.1, 0.02, 0.02), at=(0.0, 0.21, 0.0))
    inside = box_part((0.1, 0.1, 0.1))
    assert shadow_casters(model(tape, body, handle, inside), MATERIALS).tolist() == [False, True, True, False]
    print_ = catalog_object("carton_300x200x150")
    casts = shadow_casters(print_, materials())
    by_material = {part.material: bool(casts[number]) for number, part in enumerate(print_.parts)}
    assert by_material["kraft_dark"]
    assert not by_material["print_blue"]
    assert not by_material["label_paper"]


def test_of_two_equal_boxes_one_casts_and_film_never_does() -> None:
    pallet = catalog_object("epal1")
    assert shadow_casters(pallet, materials()).sum() > 15
    wrap = catalog_object("wrap_1200x800x1000")
    assert not shadow_casters(wrap, materials()).any()
