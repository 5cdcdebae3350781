"""Nodes of weftex for ComfyUI: texture synthesis from samples."""

from .nodes import NODES

NODE_CLASS_MAPPINGS = {f"Weftex{node.__name__}": node for node in NODES}
NODE_DISPLAY_NAME_MAPPINGS = {f"Weftex{node.__name__}": node.TITLE for node in NODES}
for _node in NODES:
    _node.DESCRIPTION = _node.__doc__

__all__ = ["NODE_CLASS_MAPPINGS", "NODE_DISPLAY_NAME_MAPPINGS"]
