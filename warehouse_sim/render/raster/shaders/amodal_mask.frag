layout(location = 0) out float out_covered;

void main() {
    out_covered = 1.0;
}
