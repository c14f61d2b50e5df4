"""From thermal pictures to where the rover is: camera model, features, registration, localization."""
