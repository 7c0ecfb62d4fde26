"""What is seen: the grey picture, where its content is, edge points and their directions."""
