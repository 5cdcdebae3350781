"""HTML pages that stand on their own: the report on a result, the comparison of all methods."""

from weftex.pages.comparison_page import Comparison
from weftex.pages.comparisons import compare
from weftex.pages.report_page import Report
from weftex.pages.reports import report

__all__ = ["Comparison", "Report", "compare", "report"]
