"""Windows of an endless plane, for methods that fill holes: see `weftex.endless.plane`."""
