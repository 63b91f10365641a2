"""What can be known of a motion beyond its odometry: courses from fixes, and closed forms to check against."""
