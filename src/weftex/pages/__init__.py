"""Pages of HTML that stand on their own: reports and comparisons."""
