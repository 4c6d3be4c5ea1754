"""What an agent sees: visibility of objects, poses that show an object, and paths to it."""
