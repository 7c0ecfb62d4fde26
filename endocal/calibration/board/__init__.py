"""What tells a chessboard from all else in a picture: corners, crossings, the numbers of its lines."""
