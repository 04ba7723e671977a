"""Times of files in seconds, by cftime's calendars."""

import re

import numpy

from ..errors import needed
from ..units import converted

cftime = needed("cftime")
EPOCH = "seconds since 1970-01-01"


def is_date(units):
    return bool(re.search(r"\bsince\b|%Y%m", units, re.I))


def date_of(seconds, calendar):
    """The date, in ISO 8601 and its own calendar, of seconds from 1970 on."""
    zero = True if seconds < -62e9 else None
    return cftime.num2date(seconds, EPOCH, calendar, has_year_zero=zero).isoformat()


def seconds_of(values, units, calendar):
    """Times in seconds, from 1970 on if the units tell a date. Raises ValueError."""
    values = numpy.asarray(values, float)
    if not numpy.isfinite(values).all():
        raise ValueError("some are missing")
    if re.fullmatch(r"day as %Y%m%d(\.%f)?", units):
        days = numpy.floor(values).astype(int)
        dates = [cftime.datetime(day // 10000, day // 100 % 100, day % 100, calendar=calendar) for day in days.ravel()]
        return _numbers(dates, calendar) + (values - days).ravel() * 86400
    if not is_date(units):
        return converted(values, units, "s").ravel()
    step, _, start = re.split(r"(\s+since\s+)", units, 1, re.I) if "%" not in units else (units, "", "")
    if re.search(r"\d-[A-Za-z]{3,9}-\d", start):  # 1-Jan-2000: a month in letters cannot be mistaken for a day
        start = needed("dateutil.parser").parse(start).isoformat(" ")
    for zero in None, True:  # only some calendars have a year 0, but files of others use it
        try:
            dates = cftime.num2date(values.ravel(), f"{step} since {start}", calendar, has_year_zero=zero)
            return _numbers(dates, calendar, zero)
        except (ValueError, TypeError) as error:
            failure = error
    raise ValueError(f"'{units}', calendar '{calendar}', is not understood: {failure}")


def seconds_of_texts(texts):
    """Dates such as 2005-08-28_03:00:00 as seconds from 1970 on. Raises ValueError."""
    texts = [text.decode() if isinstance(text, bytes) else str(text) for text in numpy.ravel(texts)]
    dates = [text.strip("\0 ").replace("_", "T").removesuffix("Z") for text in texts]
    return numpy.array(dates, "datetime64[us]").astype(float) / 1e6


def _numbers(dates, calendar, zero=None):
    return numpy.asarray(cftime.date2num(dates, EPOCH, calendar, has_year_zero=zero), float)
