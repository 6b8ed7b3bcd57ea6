"""An OpenDocument package: the files of a document in a zip. The same content gives the same bytes.

Source:   OpenDocument 1.3 part 2: ``mimetype`` first and stored, ``META-INF/manifest.xml`` lists the rest.
"""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping
from typing import Final

from pcaccess.sheet.ods.xml import HEAD, element

MEDIA_TYPE: Final = "application/vnd.oasis.opendocument.spreadsheet"
CHART_TYPE: Final = "application/vnd.oasis.opendocument.chart"
_EPOCH: Final = (1980, 1, 1, 0, 0, 0)
"""The first time that a zip can say; a time of its own would make every book another one."""
_MANIFEST: Final = "urn:oasis:names:tc:opendocument:xmlns:manifest:1.0"


def pack(files: Mapping[str, str], folders: Mapping[str, str]) -> bytes:
    """A document of XML files by path. ``folders``: media types of the documents inside, by ``path/``."""
    entries = {"/": MEDIA_TYPE, **folders, **dict.fromkeys(files, "text/xml")}
    listed = [
        element(
            "manifest:file-entry",
            {
                "manifest:full-path": path,
                "manifest:version": "1.3" if path == "/" else None,
                "manifest:media-type": media_type,
            },
        )
        for path, media_type in entries.items()
    ]
    manifest = element("manifest:manifest", {"xmlns:manifest": _MANIFEST, "manifest:version": "1.3"}, *listed)
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as package:
        _add(package, "mimetype", MEDIA_TYPE, zipfile.ZIP_STORED)
        for path, content in files.items():
            _add(package, path, content)
        _add(package, "META-INF/manifest.xml", HEAD + manifest)
    return buffer.getvalue()


def _add(package: zipfile.ZipFile, path: str, content: str, how: int = zipfile.ZIP_DEFLATED) -> None:
    info = zipfile.ZipInfo(path, _EPOCH)
    info.compress_type = how
    info.external_attr = 0o644 << 16
    package.writestr(info, content.encode())
