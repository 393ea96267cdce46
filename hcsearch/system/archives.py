"""Entries of zip archives that have no dates, so that equal files make equal archives."""

from __future__ import annotations

from zipfile import ZIP_DEFLATED, ZipInfo

_DATE = (1980, 1, 1, 0, 0, 0)  # the first that the format can hold


def undated_entry(name: str) -> ZipInfo:
    """Return the entry for a compressed file that its owner may write and all may read."""
    entry = ZipInfo(name, _DATE)
    entry.compress_type = ZIP_DEFLATED
    entry.external_attr = 0o644 << 16
    return entry
