"""The least-squares fits: which points lie on one line, and the model that makes lines straight."""
