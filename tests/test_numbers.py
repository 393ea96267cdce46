"""Numbers are written out, as people write them."""

import pytest

from hcsearch.system.terminal import bytes_text, duration_text, short_number


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [
        (10.0, 1, "10"),
        (162.0, 2, "160"),
        (-17361.2, 4, "-17360"),
        (0.141, 4, "0.141"),
        (4.2e12, 2, "4.2e+12"),
        (0, 2, "0"),
    ],
)
def test_numbers_have_digits_and_no_powers_of_ten(value, digits, text):
    assert short_number(value, digits) == text


def test_times_and_sizes_are_written_out():
    assert bytes_text(1.62e8) == "160 MB"
    assert duration_text(80 * 86400.0) == "80 days"
    assert duration_text(120 * 86400.0) == "120 days"
