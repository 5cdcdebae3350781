"""Images larger than memory, written block by block."""

from weftex.planes.plane_file import PlaneFile, open_plane
from weftex.planes.writing import Written, check, stream

__all__ = ["PlaneFile", "Written", "check", "open_plane", "stream"]
