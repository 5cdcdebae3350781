"""What methods show of their work is what they do."""

from tests.twins import windows as twin_windows  # noqa: F401
