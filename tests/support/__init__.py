"""What several tests share: exact systems, synthetic rolls, fake analyses, paths."""
