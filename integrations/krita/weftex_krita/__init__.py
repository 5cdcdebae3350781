"""weftex in Krita: Tools > Scripts > weftex."""

try:
    from krita import Krita
except ImportError:  # outside Krita only the other modules are of use
    Krita = None

if Krita is not None:
    from .extension import WeftexExtension

    Krita.instance().addExtension(WeftexExtension(Krita.instance()))
