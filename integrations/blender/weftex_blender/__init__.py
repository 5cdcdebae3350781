"""weftex in Blender: a tab in the sidebar of the Image Editor."""

from __future__ import annotations

import bpy

_NEEDS = (0, 2, 0)
_problem = ""
try:
    import weftex

    if tuple(map(int, weftex.__version__.split(".")[:3])) < _NEEDS:
        _problem = f"weftex {weftex.__version__} is too old; install this extension again"
except ImportError as error:
    _problem = f"weftex cannot be loaded ({error}); install the extension for your system again"

if not _problem:
    from .operators import OPERATORS
    from .settings import PROPERTIES

    _GROUPS = {
        task: type(f"WEFTEX_PG_{task}", (bpy.types.PropertyGroup,), {"__annotations__": own})
        for task, own in PROPERTIES.items()
    }


class WEFTEX_PT_sidebar(bpy.types.Panel):
    """The tab of weftex"""

    bl_idname, bl_label = "WEFTEX_PT_sidebar", "weftex"
    bl_space_type, bl_region_type, bl_category = "IMAGE_EDITOR", "UI", "weftex"

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the operators, each above what it asks for."""
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        if _problem:
            layout.label(text=_problem, icon="ERROR")
            return
        for task, names in (("synth", ("make_more", "match_maps")),
                            ("tile", ("make_tileable", "new_material")),
                            ("fill", ("fill",))):  # fmt: skip
            box = layout.box()
            settings = getattr(context.scene, f"weftex_{task}")
            for name in names:
                operator = box.operator(f"weftex.{name}")
            for name in PROPERTIES[task]:
                box.prop(settings, name)
            if task == "fill":
                box.prop_search(context.scene, "weftex_mask", bpy.data, "images", text="Mask")
                operator.mask = context.scene.weftex_mask


def register() -> None:
    """Add the tab, the operators and their settings."""
    if not _problem:
        for one in (*OPERATORS, *_GROUPS.values()):
            bpy.utils.register_class(one)
        for task, group in _GROUPS.items():
            setattr(bpy.types.Scene, f"weftex_{task}", bpy.props.PointerProperty(type=group))
        bpy.types.Scene.weftex_mask = bpy.props.StringProperty(
            name="Mask", description="Image that is white where the hole is; empty: transparency"
        )
    bpy.utils.register_class(WEFTEX_PT_sidebar)


def unregister() -> None:
    """Remove all that `register` added."""
    bpy.utils.unregister_class(WEFTEX_PT_sidebar)
    if not _problem:
        del bpy.types.Scene.weftex_mask
        for task, group in _GROUPS.items():
            delattr(bpy.types.Scene, f"weftex_{task}")
            bpy.utils.unregister_class(group)
        for one in reversed(OPERATORS):
            bpy.utils.unregister_class(one)
