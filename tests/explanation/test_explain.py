"""What methods show of their work is what they do."""

import numpy as np
import pytest

import weftex
from tests.twins import windows as twin_windows  # noqa: F401
from weftex.explanation import WATCHERS
from weftex.methods import METHODS
