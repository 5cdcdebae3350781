"""The commands of `weftex`, one a module: its `run` takes the arguments after its name."""
