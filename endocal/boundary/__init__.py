"""The visible circle of an endoscope picture: what it is and how it is found."""
