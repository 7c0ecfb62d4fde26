"""From a picture of straight lines to a division model: edges, Hough entropy, search, refinement."""
