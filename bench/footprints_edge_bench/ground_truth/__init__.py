"""What is truly known of images, one kind of dataset a file."""
