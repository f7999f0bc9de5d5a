"""Time histories on a weighted subset of the contact points, which all points follow."""
