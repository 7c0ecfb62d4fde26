"""The model over the zoom: the table, its law, and following a clip frame by frame."""
