"""Pictures and clips with known truth, rendered analytically."""
