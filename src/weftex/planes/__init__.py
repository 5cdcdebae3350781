"""Pictures larger than memory: written block by block, on one machine or many, or made when asked.

Nothing of weftex needs this package but the command line and the studio.
"""

from weftex.planes.lazy import plane
from weftex.planes.opened import PlaneFile, open_plane
from weftex.planes.writing import Written, stream

__all__ = ["PlaneFile", "Written", "open_plane", "plane", "stream"]
