"""The system of bodies and interfaces, its checks and its file formats."""
