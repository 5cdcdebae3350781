"""What several methods search windows with; structures of one method are in its package."""
