"""The Hough entropy of Lee et al. 2013 with the undistorted gradient (HEwG), over grids of models."""
