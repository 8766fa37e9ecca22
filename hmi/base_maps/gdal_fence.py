"""GDAL shut in: one driver, no network, no file but the one it is given. Only for a process of its own."""

from __future__ import annotations

import os
from pathlib import Path

DRIVER = "GTiff"  # the only one a file is opened with; each other driver is code that a stranger's file could reach

_FENCE = {
    "GDAL_DISABLE_READDIR_ON_OPEN": "EMPTY_DIR",  # no files beside the photo (.ovr, .aux.xml, .msk)
    "GDAL_GEOREF_SOURCES": "INTERNAL",  # no .tfw or .prj either
    "GDAL_PAM_ENABLED": "NO",  # reads and writes no .aux.xml
    "GDAL_DRIVER_PATH": "disable",  # no plugins
    "GDAL_SKIP": "VRT HTTP WMS WMTS WCS DAAS EEDA EEDAI PLMOSAIC STACIT STACTA OGCAPI DERIVED",
    "CPL_VSIL_CURL_ALLOWED_EXTENSIONS": ".none",
    "CPL_DEBUG": "OFF",
    "PROJ_NETWORK": "OFF",  # no grids from the Internet
    "GDAL_CACHEMAX": "256",  # MB
    "GDAL_NUM_THREADS": "1",  # the console needs the other cores
    "OPENBLAS_NUM_THREADS": "1",
}


def shut_in(folder: Path) -> None:
    """Set the fence up; call it before ``rasterio`` is imported.

    Args:
        folder: the only place for temporary files.
    """
    os.environ.update(_FENCE)
    os.environ["CPL_TMPDIR"] = str(folder)
