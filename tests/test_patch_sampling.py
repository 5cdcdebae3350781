import numpy as np, pytest, weft, reference
