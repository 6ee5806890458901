import numpy as np
import pytest

from warehouse_sim.scene import Distribution
from warehouse_sim.scene.draft import Area, SceneDraft
from warehouse_sim.scene.lighting import LightingConfig, draw_lighting, hang_luminaires, illuminance, planckian_rgb
from warehouse_sim.schema import Light

UP, DOWN = np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, -1.0])


def test_illuminance_follows_the_inverse_square_and_the_cosine() -> None:
    lamp = Light("point", np.array([0.0, 0.0, 5.0]), DOWN, 1000.0)
    assert illuminance((lamp,), np.zeros(3), UP) == pytest.approx(1000 / 25)
    aside = illuminance((lamp,), np.array([5.0, 0.0, 0.0]), UP)
    assert aside == pytest.approx(1000 * np.cos(np.pi / 4) ** 3 / 25)
    assert illuminance((lamp, lamp), np.zeros(3), UP) == pytest.approx(80.0)
    assert illuminance((lamp,), np.zeros(3), DOWN) == 0.0


def test_a_spot_is_full_inside_and_dark_outside_its_cone() -> None:
    lamp = Light("spot", np.array([0.0, 0.0, 1.0]), DOWN, 100.0, cone_inner=0.5, cone_outer=1.0)
    full = illuminance((lamp,), np.array([np.tan(0.49), 0.0, 0.0]), UP)
    assert full == pytest.approx(100 * np.cos(0.49) ** 3)
    assert 0.0 < illuminance((lamp,), np.array([np.tan(0.8), 0.0, 0.0]), UP) < 100 * np.cos(0.8) ** 3
    assert illuminance((lamp,), np.array([np.tan(1.01), 0.0, 0.0]), UP) == 0.0


def test_black_body_colours() -> None:
    # The daylight white of sRGB (D65) is close to the black body of 6500 K.
    np.testing.assert_allclose(planckian_rgb(6504.0), 1.0, atol=0.06)
    for temperature in (1800.0, 2222.0, 3000.0, 4000.0, 4001.0, 9000.0):
        assert np.array([0.2126, 0.7152, 0.0722]) @ planckian_rgb(temperature) == pytest.approx(1.0)
    red_over_blue = [planckian_rgb(t)[0] / planckian_rgb(t)[2] for t in (2000.0, 3000.0, 4000.0, 5000.0, 8000.0)]
    assert red_over_blue == sorted(red_over_blue, reverse=True)
    for joint in (2222.0, 4000.0):
        np.testing.assert_allclose(planckian_rgb(joint), planckian_rgb(joint + 0.01), atol=2e-3)


def test_lamps_hang_under_their_luminaires_over_the_aisle() -> None:
    draft = SceneDraft()
    lamps = hang_luminaires(draft, LightingConfig(luminaires=2, mounting_height=6.0), Area(-4.0, 4.0, -8.0, 0.0))
    assert [item.model for item in draft.instances] == ["highbay_luminaire"] * 2
    np.testing.assert_allclose([item.T_world_object[:3, 3] for item in draft.instances], [[-2, -4, 6], [2, -4, 6]])
    for lamp, item in zip(lamps, draft.instances, strict=True):
        assert lamp[2] < item.T_world_object[2, 3] - draft.models[item.model].size[2] / 2


def test_exposure_makes_a_white_surface_on_the_racks_front_one() -> None:
    config = LightingConfig(exposure_ev=Distribution.constant(0.0))
    lamps = [np.array([0.0, -4.0, 7.0])]
    lighting = draw_lighting(config, lamps, np.random.default_rng(0))
    front = illuminance(lighting.lights, np.array([0.0, 0.0, 1.5]), np.array([0.0, -1.0, 0.0])) + lighting.ambient / 2
    assert lighting.exposure * front / np.pi == pytest.approx(1.0)
    brighter = LightingConfig(exposure_ev=Distribution.constant(1.0))
    assert draw_lighting(brighter, lamps, np.random.default_rng(0)).exposure == pytest.approx(2 * lighting.exposure)


def test_a_warm_lamp_is_warm_and_white_balance_makes_it_white() -> None:
    warm = LightingConfig(temperature=Distribution.constant(3000.0), white_balance=6500.0)
    red, _, blue = draw_lighting(warm, [np.array([0.0, -4.0, 7.0])], np.random.default_rng(0)).lights[0].color
    assert red > 1.2 > 0.6 > blue
    white = LightingConfig(temperature=Distribution.constant(3000.0), white_balance=3000.0)
    color = draw_lighting(white, [np.array([0.0, -4.0, 7.0])], np.random.default_rng(0)).lights[0].color
    np.testing.assert_allclose(color, 1.0)


def test_exposure_follows_the_metered_height() -> None:
    lamps = [np.array([0.0, -2.0, 7.0])]
    low, high = (draw_lighting(LightingConfig(meter_height=z), lamps, np.random.default_rng(0)) for z in (1.5, 5.0))
    assert high.exposure < low.exposure
    with pytest.raises(ValueError, match=r"meter_height must be 0\.2-8 m, found 9"):
        LightingConfig(meter_height=9.0)
