"""How good a result is: one file a measure, and `assess`, which takes them all."""
