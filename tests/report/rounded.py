"""Numbers of pages beside the values that they were rounded from."""

import decimal
import re

NUMBER = re.compile(r"[+-]?\d[\d,]*(?:\.\d+)?(?:e[+-]?\d+)?")


def agrees(text, value):
    """Whether the text is the value, rounded to the text's own last digit."""
    digits = decimal.Decimal(text.replace(",", ""))
    return abs(float(digits) - value) <= 0.5 * 10.0 ** digits.as_tuple().exponent * (1 + 1e-9)
