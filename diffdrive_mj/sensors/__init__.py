"""What a robot measures on itself: a recording becomes the readings of real sensors."""
