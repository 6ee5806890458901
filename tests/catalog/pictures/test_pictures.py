"""Labels hold codes that other people's decoder reads, and a name is one picture."""

import numpy as np
import pytest
import zxingcpp

from warehouse_sim.catalog.pictures.draw import PICTURES, code128, draw_picture, with_check_digit
from warehouse_sim.catalog.pictures.sheet import HEIGHT_PX, WIDTH_PX
from warehouse_sim.errors import ConfigError, UnknownNameError


def read(image: np.ndarray) -> dict[str, str]:
    """Return the texts of the codes in an sRGB image by kind."""
    codes = zxingcpp.read_barcodes(np.ascontiguousarray(image[..., :3]))
    return {code.format.name: code.text.replace("(", "").replace(")", "") for code in codes}


@pytest.mark.parametrize("kind", ["shipping_label", "article_label"])
def test_both_codes_of_a_label_are_read_and_say_the_same(kind: str) -> None:
    seen = set()
    for key in range(12):
        codes = read(draw_picture(f"{kind}:{key}"))
        assert set(codes) == {"Code128", "QRCode"}
        assert codes["QRCode"].startswith(codes["Code128"])
        seen.add(codes["Code128"])
    assert len(seen) == 12


def test_the_number_on_a_shipping_label_has_gs1s_check_digit() -> None:
    """Weighted 3 and 1 from the left of 18 digits, the sum is a multiple of ten."""
    for key in range(5):
        number = read(draw_picture(f"shipping_label:{key}"))["Code128"]
        assert len(number) == 20
        assert number.startswith("00")
        assert sum(int(digit) * (3, 1)[place % 2] for place, digit in enumerate(number[2:])) % 10 == 0


def test_check_digit_of_the_general_specifications_example() -> None:
    assert with_check_digit("37610425002123456") == "376104250021234569"


@pytest.mark.parametrize("key", ["04-012-3", "A-17", "B-03-22-1", "Dock 7"])
def test_a_location_label_is_read_as_its_key(key: str) -> None:
    assert read(draw_picture(f"location_label:{key}"))["Code128"] == key


@pytest.mark.parametrize("kind", PICTURES)
def test_a_name_is_one_picture(kind: str) -> None:
    first, second = draw_picture(f"{kind}:1"), draw_picture(f"{kind}:2")
    draw_picture.cache_clear()
    again = draw_picture(f"{kind}:1")
    assert first.shape == (HEIGHT_PX, WIDTH_PX, 4)
    np.testing.assert_array_equal(first, again)
    assert not np.array_equal(first, second)


def test_ink_on_board_leaves_most_of_it_bare() -> None:
    cover = draw_picture("carton_print:1")[..., 3]
    assert 0.03 < (cover > 127).mean() < 0.5
    assert (draw_picture("shipping_label:1")[..., 3] == 255).all()


def test_what_cannot_be_drawn_is_named() -> None:
    with pytest.raises(UnknownNameError, match="kind of picture"):
        draw_picture("poster:1")
    with pytest.raises(ConfigError, match="printable ASCII"):
        code128("")
