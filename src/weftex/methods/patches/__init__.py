"""What methods that lay patches share: patch-based sampling and image quilting."""
