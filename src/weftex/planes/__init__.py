"""Images larger than memory, written block by block on one machine or many."""

from weftex.planes.plane_file import PlaneFile, open_plane
from weftex.planes.writing import Written, check, repair, stream

__all__ = ["PlaneFile", "Written", "check", "open_plane", "repair", "stream"]
