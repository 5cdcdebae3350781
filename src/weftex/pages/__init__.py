"""HTML pages that stand on their own: the report on a result, the comparison of all methods."""

from weftex.pages.comparisons import Comparison, compare
from weftex.pages.reports import Report, report

__all__ = ["Comparison", "Report", "compare", "report"]
