"""The article's tables and figures, made anew: ``make tables`` writes docs/results.md and its pictures."""
