"""The systems of the article and of those it compares with, one a file, behind one registry."""
