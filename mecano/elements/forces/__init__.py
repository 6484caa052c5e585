"""Forces and moments: loads at nodes, couples, brakes."""
